"""Motion capture, laptop and robots on machines of their own, without multicast."""

import pytest

pytest.importorskip('rclpy')

from network_namespaces import NoNetworkError, in_a_process
from network_rehearsal import PEERS, SERVER, roll_after_the_laptop_is_cut_off

WAY = 0.16  # m


@pytest.mark.parametrize(
    ('way', 'nb_robots'),
    [
        (PEERS, 2),
        (SERVER, 2),
        pytest.param(PEERS, 8, marks=pytest.mark.nightly),
        pytest.param(SERVER, 8, marks=pytest.mark.nightly),
    ],
)
def test_robots_over_a_network_whose_plug_is_pulled(way, nb_robots, domain, tmp_path):
    try:
        ways = in_a_process(roll_after_the_laptop_is_cut_off, way, nb_robots, domain, tmp_path)
    except NoNetworkError as error:
        pytest.skip(str(error))

    assert len(ways) == nb_robots
    assert max(ways) < WAY
