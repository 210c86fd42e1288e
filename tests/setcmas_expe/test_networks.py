"""Motion capture, laptop and robots on machines of their own, without multicast."""

import pytest

pytest.importorskip('rclpy')

from network_namespaces import on_a_network
from network_rehearsal import roll_after_the_laptop_is_cut_off

WAY = 0.16  # m
NB_ROBOTS = 2


@pytest.mark.nightly
def test_robots_over_a_network_whose_plug_is_pulled(domain, tmp_path):
    ways = on_a_network(roll_after_the_laptop_is_cut_off, NB_ROBOTS, domain, tmp_path)

    assert len(ways) == NB_ROBOTS
    assert max(ways) < WAY
