import math

import numpy as np
import pytest

from setcmas_expe.emulation.emulated_fleet import EmulatedFleet, truncated
from setcmas_simu.robots.identified_robot import IdentifiedRobot, Response
from setcmas_simu.robots.model import ROBOT_LIMITS

BURGER = ROBOT_LIMITS['burger']
RNG = np.random.default_rng(0)
LARGEST = 2**31 / 100


@pytest.mark.parametrize(
    ('sent', 'driven'),
    [(0.119, 0.11), (-0.119, -0.11), (0.009, 0.0), (0.2, 0.2), (math.nan, 0.0),
     (math.inf, LARGEST), (-math.inf, -LARGEST)],
)  # fmt: skip
def test_commands_are_cut_to_hundredths_of_32_bits(sent, driven):
    assert truncated(sent) == pytest.approx(driven)


def test_the_last_command_lasts_and_wheel_odometry_counts_from_zero():
    robots = EmulatedFleet(np.array([[2.0], [1.0], [math.pi / 2]]), BURGER, RNG)
    robots.command(0, 0.1, 0.0)
    assert robots.odometry[:, 0].tolist() == [0.0, 0.0, 0.0]

    for _ in range(1000):
        robots.step(0.1)

    assert robots.poses[:, 0] == pytest.approx([2.0, 11.0, math.pi / 2])
    assert robots.odometry[:, 0] == pytest.approx([10.0, 0.0, 0.0])
    robots.command(0, 1.0, 0.0)
    robots.step(0.02)
    assert robots.V[0] == pytest.approx(BURGER.V_max)  # by the firmware


def test_robots_of_a_model_follow_with_its_lag_and_stand_at_once_without_torque():
    robots = EmulatedFleet(
        np.zeros((3, 1)),
        BURGER,
        RNG,
        IdentifiedRobot(Response(lag=0.3, delay=0.1), Response()),
    )
    robots.command(0, 0.2, 0.5)
    for _ in range(20):
        robots.step(0.02)

    assert robots.V[0] == pytest.approx(0.2 * -math.expm1(-0.3 / 0.3), rel=0.03)
    assert robots.omega[0] == pytest.approx(0.5)
    robots.set_torque(0, on=False)
    robots.step(0.02)
    assert robots.V[0] == 0.0


def test_a_lidar_sees_the_nearest_thing_in_each_direction():
    poses = np.array([[1.0, 2.0, -math.pi / 2], [2.0, 1.0, 0.0]]).T
    robots = EmulatedFleet(poses, BURGER, RNG)
    people = np.array([[1.0, 1.0, 0.15], [1.0, 3.0, 0.2]]).T
    measured = robots.scan(0, people)

    assert measured[0] == pytest.approx(0.85)
    assert measured[45] == pytest.approx(math.sqrt(2) - 0.07, rel=1e-3)  # a robot to its left
    assert measured[180] == pytest.approx(0.8)
    assert measured[90] == math.inf
    assert np.isinf(robots.scan(1, np.empty((3, 0)))[:90]).all()
