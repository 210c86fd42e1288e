import math

import pytest

from setcmas_expe.guard.commands import SILENCE_S
from setcmas_expe.guard.stop_on_silence import REPEAT_S, StopOnSilence


def test_silence_after_a_command_to_move_stops_the_robot_for_a_while():
    guard = StopOnSilence(9.9)
    guard.hear(0.1, 0.0, 10.0)

    assert not guard.must_stop(10.0 + SILENCE_S - 0.01)
    assert guard.must_stop(10.31)
    assert not guard.moving
    guard.hear(0.0, 0.0, 10.32)  # its own zero
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
        guard.hear(V, omega, 10.0)

    assert not any(guard.must_stop(10.0 + t) for t in (0.1, 0.4, 5.0))


def test_commands_that_keep_coming_are_left_alone():
    guard = StopOnSilence(9.9)
    for step in range(100):
        guard.hear(0.0, 0.5, step / 20)
        assert not guard.must_stop(step / 20 + 0.04)


def test_a_new_command_ends_the_stop_at_once():
    guard = StopOnSilence(9.9)
    guard.hear(0.1, 0.0, 10.0)
    assert guard.must_stop(10.5)
    guard.hear(0.1, 0.0, 10.6)

    assert not guard.must_stop(10.65)
    assert guard.must_stop(11.0)


def test_a_command_that_is_not_a_number_does_not_keep_a_robot_going():
    guard = StopOnSilence(9.9)
    guard.hear(0.1, 0.0, 10.0)
    guard.hear(math.nan, 0.0, 10.2)

    assert guard.must_stop(10.31)


def test_an_infinite_command_sets_a_robot_going_and_is_ended():
    guard = StopOnSilence(9.9)
    guard.hear(math.inf, 0.0, 10.0)
    guard.hear(math.inf, 0.0, 10.2)

    assert guard.must_stop(10.31)
