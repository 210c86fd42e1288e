import math

import pytest

from setcmas_expe.guard.guard_commands import REPEAT_S, SILENCE_S, STOP, Commands

FORWARD = (0.1, 0.0)


def test_a_command_is_followed_until_silence_and_one_that_is_not_a_number_is_silence():
    commands = Commands(9.9)
    assert commands.newest(9.9) == STOP
    commands.receive(*FORWARD, 10.0)
    commands.receive(math.nan, 0.0, 10.2)
    assert commands.newest(10.0 + SILENCE_S - 0.01) == FORWARD
    assert commands.have_ended(10.0 + SILENCE_S + 0.01)
    assert commands.newest(10.0 + SILENCE_S + 0.01) == STOP


def test_silence_after_a_command_to_move_means_zero_for_a_while():
    commands = Commands(9.9)
    commands.receive(*FORWARD, 10.0)
    assert not commands.must_repeat_zero(10.0 + SILENCE_S - 0.01)
    assert commands.must_repeat_zero(10.31)
    commands.receive(*STOP, 10.32)  # the guard's own zero
    assert commands.must_repeat_zero(10.5)
    assert not commands.must_repeat_zero(10.4 + REPEAT_S)

    commands.receive(*FORWARD, 11.5)  # a new command ends it at once
    assert not commands.must_repeat_zero(11.55)
    assert commands.must_repeat_zero(11.9)


def test_a_robot_that_moves_already_is_stopped():
    commands = Commands(10.0)
    assert not commands.must_repeat_zero(10.2)
    assert commands.must_repeat_zero(10.31)
    assert not commands.must_repeat_zero(10.4 + REPEAT_S)


def test_silence_after_zero_is_nothing():
    commands = Commands(9.9)
    commands.receive(*FORWARD, 10.0)
    commands.receive(*STOP, 10.0)
    assert not any(commands.must_repeat_zero(10.0 + t) for t in (0.1, 0.4, 5.0))


@pytest.mark.parametrize(('first', 'later'), [(0.1, math.nan), (math.inf, math.inf)])
def test_a_command_that_is_not_a_number_does_not_keep_a_robot_going(first, later):
    commands = Commands(9.9)
    commands.receive(*STOP, 9.9)
    commands.receive(first, 0.0, 10.0)
    commands.receive(later, 0.0, 10.2)
    assert commands.must_repeat_zero(10.31)
