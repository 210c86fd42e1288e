import math

import pytest

from setcmas_expe.guard.guard_commands import LATEST_S, REPEAT_S, SILENCE_S, STOP, Commands

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


@pytest.mark.parametrize('hears_itself', [True, False])
def test_a_first_zero_that_comes_late_is_the_bridge_s_unless_it_may_be_the_guard_s_own(
    hears_itself,
):
    commands = Commands(10.0, hears_itself=hears_itself)
    now = 10.0 + SILENCE_S + 0.1  # when the guard has found its base and the bridge has found it

    commands.receive(*STOP, now)

    assert commands.have_ended(now) is hears_itself


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


@pytest.mark.parametrize('ahead', [0.0, 1.7e9, -5.0])
def test_commands_that_queue_in_the_network_are_late_whatever_the_clock_of_their_sender(ahead):
    commands = Commands(0.0)

    def late(now, delay):
        return commands.is_late(now - delay + ahead, now)

    assert not any(late(10.0 + step / 20, 0.02 + 0.03 * (step % 2)) for step in range(20))
    assert not late(12.0, 0.02 + LATEST_S - 0.01)
    assert all(late(12.5 + step / 20, 0.5 + step / 40) for step in range(40))
    assert not late(15.0, 0.03)

    commands.forget_clock()  # another computer, whose clock is a second behind
    assert not late(16.0, 1.0)
    assert late(16.5, 1.3)


def test_a_command_without_a_stamp_is_never_late():
    commands = Commands(0.0)
    assert not any(commands.is_late(0.0, float(now)) for now in range(9))
