import math

import numpy as np
import pytest

from setcmas_simu.robots.virtual_fleet import VirtualFleet


@pytest.fixture
def start():
    return np.array([[1.0, 2.0], [0.0, 0.0], [0.0, math.pi]])


def test_robots_stand_until_commanded_and_then_hold_their_command(start):
    fleet = VirtualFleet(start)
    fleet.step(0.1, now=0.0)
    np.testing.assert_array_equal(fleet.poses, start)

    fleet.command(1, (0.5, 0.0, 0.0), now=0.0)
    for _ in range(10):
        fleet.step(0.1, now=1e9)

    np.testing.assert_allclose(fleet.poses[0], [1.0, 1.5])
    assert fleet.twists[0].tolist() == [0.0, 0.5]


def test_an_old_command_stops_the_robot_when_a_timeout_is_set(start):
    fleet = VirtualFleet(start, cmd_timeout=0.5)
    fleet.command(0, (1.0, 0.0, 1.0), now=10.0)

    fleet.step(0.1, now=10.5)
    assert fleet.twists[:, 0].tolist() == [1.0, 0.0, 1.0]
    fleet.step(0.1, now=10.6)
    assert not fleet.twists.any()


@pytest.mark.parametrize(
    'command',
    [(math.nan, 0.0, 0.0), (0.1, 0.0, math.inf), (0.0, -math.inf, math.nan), (1e308, 0.0, 0.0)],
)
def test_a_command_that_is_not_finite_stops_the_robot(start, command):
    fleet = VirtualFleet(start)
    fleet.command(0, (1.0, 0.0, 0.0), now=0.0)
    assert not fleet.command(0, command, now=0.0)
    fleet.step(0.1, now=0.0)

    np.testing.assert_array_equal(fleet.poses, start)
