import math

import pytest

from setcmas_expe.guard.obedience import (
    RUNS_AWAY_AFTER_S,
    SLOWS_WITHIN_OVER_RADIO_S,
    SLOWS_WITHIN_S,
    Disobedience,
    Obedience,
)
from setcmas_simu.robots.model import IDEAL, ROBOT_LIMITS

STAND = [(0.0, 0.0)]


def verdicts(obedience, wheels, commands=STAND):
    """Yield a time and what the check reports then, 20 times a second.

    Wheels have (V, omega), or None where they are silent. The last command goes on.
    """
    for step, measured in enumerate(wheels):
        if measured:
            obedience.measure(*measured, step / 20)
        command = commands[min(step, len(commands) - 1)]
        yield step / 20, obedience.update(*command, step / 20)


def judged(commanded, wheels, seconds=1.0, silent_from=9.9):
    """Return what the check reports last of wheels that are commanded otherwise."""
    steps = range(int(20 * seconds) + 1)
    measured = [wheels if step / 20 < silent_from else None for step in steps]
    return [*verdicts(Obedience(IDEAL), measured, [commanded])][-1][1]


@pytest.mark.parametrize(
    ('commanded', 'wheels', 'seconds', 'expected'),
    [
        ((0.1, 0.0), (0.1, 0.0), 1.0, None),
        ((-0.1, 0.0), (0.0, 0.0), 1.0, Disobedience.DOES_NOT_TURN),
        ((0.0, 1.0), (0.0, 0.0), 1.0, Disobedience.DOES_NOT_TURN),
        ((0.0, -1.0), (0.0, -1.0), 1.0, None),
        ((0.1, 0.0), (0.0, 0.0), 0.6, None),
        ((0.04, 0.0), (0.0, 0.0), 1.0, None),
        ((0.0, 0.0), (0.0, 0.0), 1.0, None),
        ((0.0, 0.0), (-0.1, 0.0), 1.0, Disobedience.IGNORES_ZERO),
        ((0.0, 0.0), (0.0, 0.5), 1.0, Disobedience.IGNORES_ZERO),
        ((0.0, 0.0), (0.0, 0.3), 1.0, None),
        ((0.0, 0.0), (0.1, 0.0), 0.4, None),
    ],
)
def test_wheels_do_what_they_are_commanded(commanded, wheels, seconds, expected):
    assert judged(commanded, wheels, seconds) is expected


def test_a_robot_that_falls_silent_is_off_and_one_that_was_always_silent_is_unknown():
    forward = (0.1, 0.0)
    assert judged(forward, forward, 2.0, silent_from=0.5) is Disobedience.SILENT
    assert not judged(forward, forward, 2.0, silent_from=0.0)


@pytest.mark.parametrize('number', [math.nan, math.inf])
def test_wheels_that_measure_no_number_are_silent_from_the_first_message_on(number):
    assert judged((0.0, 0.0), (number, 0.0), 0.9) is None
    assert judged((0.0, 0.0), (0.0, number), 2.0) is Disobedience.SILENT


def test_wheels_that_slow_down_have_more_time():
    speeds = [0.2, 0.2, 0.15, *[0.1] * 30]
    wheels = [(speed, 0.0) for speed in speeds]
    found = [verdict for _, verdict in verdicts(Obedience(IDEAL), wheels)]

    assert not any(found[: round(20 * RUNS_AWAY_AFTER_S)])
    assert found[-1]


NOISE = [(0.001, 0.05), (-0.001, -0.08), (0.0, 0.087)]  # of encoders and a gyroscope at rest
CREEPS = (0.0, 0.3)  # the slow turn of a robot that has not proved its axes


def first_cut(wheels, commands=STAND, slows_within=SLOWS_WITHIN_S):
    """Return after how many s a burger ignores zero."""
    obedience = Obedience(ROBOT_LIMITS['burger'], slows_within)
    found = verdicts(obedience, wheels, commands)
    return next((t for t, verdict in found if verdict is Disobedience.IGNORES_ZERO), None)


def test_a_deaf_robot_that_creeps_is_found_though_a_reading_fails():
    for slow in (CREEPS, (0.01, 0.0), (-0.01, 0.01)):
        wheels = [slow] * 70
        wheels[20] = wheels[50] = (0.0, 0.0)
        assert first_cut(wheels, [slow] * 10 + [(0.0, 0.0)]) == pytest.approx(2.5, abs=0.06)
    wheels = [(0.0, 0.0)] * 40 + [CREEPS] * 60  # it began late to turn
    assert first_cut(wheels, [CREEPS] * 42 + [(0.0, 0.0)]) < 4.2


@pytest.mark.parametrize(
    'wheels',
    [
        NOISE * 200,
        [(0.2, 0.0)] * 4 + [(0.02, 0.1)] * 10 + NOISE * 40,  # it brakes
        NOISE * 6 + [(0.0, 0.3)] * 100,  # a person turns it
        ([CREEPS] * 20 + [None] * 8) * 5,  # nothing is known for 0.4 s
    ],
)
def test_no_robot_at_rest_is_cut(wheels):
    assert first_cut(wheels) is None


def test_odometry_that_comes_late_over_a_radio_link_is_waited_for():
    wheels = [(0.2, 0.0)] * 13 + NOISE * 20  # it stood after 0.1 s
    assert first_cut(wheels) == pytest.approx(0.55)
    assert first_cut(wheels, slows_within=SLOWS_WITHIN_OVER_RADIO_S) is None
    deaf = first_cut([(0.2, 0.0)] * 40, slows_within=SLOWS_WITHIN_OVER_RADIO_S)
    assert deaf == pytest.approx(0.75, abs=0.06)


def test_who_came_to_rest_is_known_until_the_next_command_to_move():
    obedience = Obedience(IDEAL)
    for step in range(11):
        assert not obedience.came_to_rest
        obedience.measure(*NOISE[step % 3], step / 20)
        obedience.update(0.0, 0.0, step / 20)
    assert obedience.came_to_rest
    obedience.update(0.1, 0.0, 0.6)
    obedience.update(0.0, 0.0, 0.6)
    assert not obedience.came_to_rest
