import math

import numpy as np
import pytest

from setcmas_ctrl.filter.filter_options import Verdict
from setcmas_ctrl.si_to_uni import as_unicycles
from setcmas_ctrl.velocity_conversion import VelocityConversion, limited_rise
from setcmas_simu.robots.car import CAR
from setcmas_simu.robots.model import limits_named
from setcmas_simu.robots.omnidirectional import OMNIDIRECTIONAL
from setcmas_simu.robots.turtlebot3 import BURGER
from setcmas_simu.robots.unicycle import UNICYCLE, Unicycle


def test_speed_rises_by_so_much_and_falls_at_once():
    before = np.array([[0.1, 0.3, 0.2, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    wanted = np.array([[0.5, 0.1, -0.5, 0.12], [0.0, 0.0, 0.0, 0.16], [1.0, 2.0, 3.0, 4.0]])

    limited = limited_rise(wanted, before, 0.1)

    np.testing.assert_allclose(limited[0], [0.2, 0.1, -0.1, 0.06])
    np.testing.assert_allclose(limited[1], [0.0, 0.0, 0.0, 0.08])
    assert (limited[2] == wanted[2]).all()


MODELS = [UNICYCLE, OMNIDIRECTIONAL, Unicycle(limits_named('burger')), BURGER]
POSES = np.array([[0.0, 0.3, 4.0, 5.0], [0.0, 0.3, 0.0, 0.0], [0.0, 1.0, 2.0, -3.0]])
VELOCITIES = np.array([[0.3, -0.2, 0.4, 0.1], [0.1, -0.3, -0.4, 0.0]])


def test_robots_are_driven_by_their_models_command_or_as_unicycles():
    convert = VelocityConversion(5, komega=2.0)
    convert.use([*MODELS, CAR])
    poses, velocities = (
        np.hstack([POSES, POSES[:, :1]]),
        np.hstack([VELOCITIES, VELOCITIES[:, :1]]),
    )

    commands = convert(velocities, poses)

    wanted = as_unicycles(velocities, poses, 2.0)
    wanted[:, 1:2] = OMNIDIRECTIONAL.command(velocities[:, 1:2], poses[:, 1:2], 2.0)
    np.testing.assert_array_equal(commands, wanted)


def test_velocities_that_the_filter_keeps_are_converted_within_the_limits():
    convert = VelocityConversion(4, 1.5)
    convert.use(MODELS)
    free = convert(VELOCITIES, POSES)

    kept = convert(VELOCITIES, POSES, np.full(4, Verdict.KEPT))

    np.testing.assert_array_equal(kept[:, :2], free[:, :2])
    burger = limits_named('burger')
    for robot in (2, 3):  # on the same curve
        assert kept[0::2, robot] == pytest.approx(burger.scaled_down(*free[0::2, robot]))


def test_a_robot_without_a_pose_stands_whatever_the_filter_says():
    convert = VelocityConversion(2, 1.5)
    convert.use([UNICYCLE, OMNIDIRECTIONAL])
    unknown = np.full((3, 2), math.nan)

    for verdict in Verdict:
        assert not convert(VELOCITIES[:, :2], unknown, np.full(2, verdict)).any()
