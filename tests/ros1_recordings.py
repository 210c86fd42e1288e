"""The trajectories that were recorded from the ROS 1 stack."""

from pathlib import Path

FOLDER = Path(__file__).parent / 'data' / 'ros1'
WP_NAV = FOLDER / 'wp_nav_1.csv'
CONSENSUS = FOLDER / 'consensus_8.csv'
