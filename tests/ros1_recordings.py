"""The trajectories that were recorded from the ROS 1 stack."""

from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / 'shared' / 'reference' / 'ros1'
WP_NAV = FOLDER / 'wp_nav_1.csv'
CONSENSUS = FOLDER / 'consensus_8.csv'

needs_recordings = pytest.mark.skipif(
    not FOLDER.is_dir(), reason='the recordings of the ROS 1 stack are not beside the checkout'
)
