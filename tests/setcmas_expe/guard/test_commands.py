import math

from setcmas_expe.guard.commands import ENDED, LATEST_S, SILENCE_S, Commands

FORWARD = (0.1, 0.0)
BEHIND = 1000.0  # the clock of the sender


def test_a_command_is_followed_until_silence_and_one_that_is_not_a_number_is_silence():
    commands = Commands()
    assert commands.newest(0.0) is None
    commands.hear(*FORWARD, 10.0 - BEHIND, 10.0)
    commands.hear(math.nan, 0.0, 10.2 - BEHIND, 10.2)
    assert commands.newest(10.0 + SILENCE_S - 0.01) == FORWARD
    assert commands.newest(10.0 + SILENCE_S + 0.01) is None
    assert commands.trouble == ENDED


def test_late_commands_are_not_followed_by_whatever_clock():
    commands = Commands()
    for step in range(20):
        commands.hear(*FORWARD, step / 20 - BEHIND, step / 20 + 0.01)
    commands.hear(0.2, 0.0, 1.0 - BEHIND, 1.0 + LATEST_S + 0.05)
    assert commands.newest(1.2) == FORWARD
    for step in range(20, 40):
        commands.hear(*FORWARD, step / 20 - BEHIND, step / 20 + 1.0)
    assert commands.newest(2.95) is None
    assert commands.trouble == 'its commands come 1.0 s late'

    commands.hear(*FORWARD, 3.0 - BEHIND, 3.0)
    assert commands.newest(3.0) == FORWARD
