import math

import pytest

from setcmas_expe.guard.guard_commands import (
    ENDED,
    LATEST_S,
    REPEAT_S,
    SILENCE_S,
    Commands,
    StopOnSilence,
    accelerated,
)
from setcmas_simu.robots.model import ROBOT_LIMITS

FORWARD = (0.1, 0.0)
BEHIND = 1000.0  # the clock of the sender


def test_a_command_is_followed_until_silence_and_one_that_is_not_a_number_is_silence():
    commands = Commands()
    assert commands.newest(0.0) is None
    commands.receive(*FORWARD, 10.0 - BEHIND, 10.0)
    commands.receive(math.nan, 0.0, 10.2 - BEHIND, 10.2)
    assert commands.newest(10.0 + SILENCE_S - 0.01) == FORWARD
    assert commands.newest(10.0 + SILENCE_S + 0.01) is None
    assert commands.trouble == ENDED


def test_late_commands_are_not_followed_by_whatever_clock():
    commands = Commands()
    for step in range(20):
        commands.receive(*FORWARD, step / 20 - BEHIND, step / 20 + 0.01)
    commands.receive(0.2, 0.0, 1.0 - BEHIND, 1.0 + LATEST_S + 0.05)
    assert commands.newest(1.2) == FORWARD
    for step in range(20, 40):
        commands.receive(*FORWARD, step / 20 - BEHIND, step / 20 + 1.0)
    assert commands.newest(2.95) is None
    assert commands.trouble == 'its commands come 1.0 s late'

    commands.receive(*FORWARD, 3.0 - BEHIND, 3.0)
    assert commands.newest(3.0) == FORWARD


def test_silence_after_a_command_to_move_stops_the_robot_for_a_while():
    guard = StopOnSilence(9.9)
    guard.receive(0.1, 0.0, 10.0)

    assert not guard.must_stop(10.0 + SILENCE_S - 0.01)
    assert guard.commanded == (0.1, 0.0)
    assert guard.must_stop(10.31)
    assert guard.commanded == (0.0, 0.0)
    guard.receive(0.0, 0.0, 10.32)  # its own zero
    assert guard.must_stop(10.5)
    assert not guard.must_stop(10.4 + REPEAT_S)


def test_a_robot_that_moves_already_is_stopped():
    guard = StopOnSilence(10.0)

    assert not guard.must_stop(10.2)
    assert guard.must_stop(10.31)
    assert not guard.must_stop(10.4 + REPEAT_S)


@pytest.mark.parametrize('commands', [[(0.0, 0.0)], [(0.2, 0.1), (0.0, 0.0)]])
def test_silence_after_zero_is_nothing(commands):
    guard = StopOnSilence(9.9)
    for V, omega in commands:
        guard.receive(V, omega, 10.0)

    assert not any(guard.must_stop(10.0 + t) for t in (0.1, 0.4, 5.0))


def test_commands_that_keep_coming_are_left_alone():
    guard = StopOnSilence(9.9)
    for step in range(100):
        guard.receive(0.0, 0.5, step / 20)
        assert not guard.must_stop(step / 20 + 0.04)


def test_a_new_command_ends_the_stop_at_once():
    guard = StopOnSilence(9.9)
    guard.receive(0.1, 0.0, 10.0)
    assert guard.must_stop(10.5)
    guard.receive(0.1, 0.0, 10.6)

    assert not guard.must_stop(10.65)
    assert guard.must_stop(11.0)


@pytest.mark.parametrize(('first', 'later'), [(0.1, math.nan), (math.inf, math.inf)])
def test_a_command_that_is_not_a_number_does_not_keep_a_robot_going(first, later):
    guard = StopOnSilence(9.9)
    guard.receive(first, 0.0, 10.0)
    guard.receive(later, 0.0, 10.2)

    assert guard.must_stop(10.31)


BURGER = ROBOT_LIMITS['burger']


def test_speed_is_gained_step_by_step_up_to_the_limit_and_lost_at_once():
    speeds, followed = [], (0.0, 0.0)
    for wanted in [(9.0, 0.0)] * 4 + [(0.0, 0.0), (-0.2, 0.0)]:
        followed = accelerated(wanted, followed, BURGER, gain=0.1)
        speeds.append(followed[0])
    assert speeds == pytest.approx([0.1, 0.2, BURGER.V_max, BURGER.V_max, 0.0, -0.1])


def test_a_curve_is_kept():
    V, omega = accelerated((0.2, 1.0), (0.0, 0.0), BURGER, gain=0.07)
    assert omega / V == pytest.approx(5.0)
    assert V + 0.5 * BURGER.wheel_separation * omega == pytest.approx(0.07)
