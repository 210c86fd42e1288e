import math

import numpy as np
import pytest

from setcmas_simu.robots.identified.model import IdentifiedRobot, Response
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS
from setcmas_simu.robots.virtual_fleet import VirtualFleet

FORWARD = Response(gain=0.9, lag=0.3, delay=0.25)
TURN = Response(gain=1.1, lag=0.0, delay=0.17)


def after(model, seconds, Ts, commands):
    """Return the state of a robot; commands are (V, omega), the last one held."""
    fleet = VirtualFleet(np.zeros((3, 1)), model)
    for step in range(round(seconds / Ts)):
        V, omega = commands[min(step, len(commands) - 1)]
        fleet.command(0, (V, 0.0, omega), step * Ts)
        fleet.step(Ts, step * Ts)
    return fleet.states[:, 0]


@pytest.mark.parametrize('Ts', [0.1, 0.05, 0.013, 0.01])
def test_a_step_is_answered_with_gain_lag_and_delay_at_any_rate(Ts):
    state = after(IdentifiedRobot(FORWARD, TURN), 104 * Ts, Ts, [(0.2, 0.5)])

    elapsed = 104 * Ts
    assert state[6] == pytest.approx(0.9 * 0.2 * -math.expm1(-(elapsed - 0.25) / 0.3))
    assert state[2] == pytest.approx(1.1 * 0.5 * (elapsed - 0.17))


def test_the_way_is_the_integral_of_the_speed():
    state = after(IdentifiedRobot(FORWARD, TURN), 2.0, 0.1, [(0.2, 0.0)])

    t = 2.0 - 0.25
    assert state[0] == pytest.approx(0.9 * 0.2 * (t - 0.3 * -math.expm1(-t / 0.3)))


def test_the_way_of_commands_and_poses_delays_both_speeds():
    before = after(IdentifiedRobot(FORWARD, TURN), 2.0, 0.1, [(0.2, 0.5)])
    later = after(IdentifiedRobot(FORWARD, TURN, way=0.1), 2.1, 0.1, [(0.2, 0.5)])

    np.testing.assert_allclose(later[:8], before[:8])


@pytest.mark.parametrize('rate', [50, 100, 200])
def test_a_command_that_changes_at_each_step_is_remembered_for_the_longest_delay(rate):
    slow = IdentifiedRobot(Response(delay=2.0), Response(delay=2.0))
    commands = [(0.01 * step, 0.0) for step in range(4 * rate)]

    state = after(slow, 3.0, 1 / rate, commands)

    assert state[3] == pytest.approx(0.01 * (rate - 1))


def test_robots_of_one_model_do_not_mix_and_a_reset_forgets():
    fleet = VirtualFleet(np.zeros((3, 2)), IdentifiedRobot(FORWARD, TURN))
    for step in range(20):
        fleet.command(0, (0.2, 0.0, 0.1 * step), 0.1 * step)
        fleet.step(0.1, 0.1 * step)
    assert fleet.poses[0, 0] > 0.1
    assert not fleet.poses[:, 1].any()

    fleet.reset(0)
    fleet.step(0.1, 2.0)
    assert not fleet.poses.any()


def test_commands_are_slowed_down_on_the_same_curve():
    burger = ROBOT_MODELS['burger']
    model = IdentifiedRobot(FORWARD, TURN, burger)

    V, left, omega = model.command(np.array([[0.0], [0.5]]), np.zeros((3, 1)), 1.5)[:, 0]

    assert (V, omega) == pytest.approx(burger.scaled_down(0.5, 0.75 * math.pi))
    assert left == 0.0
