import pytest

from setcmas_expe.guard.obedience import (
    IGNORES_ZERO,
    RUNS_AWAY_AFTER_S,
    SLOWS_WITHIN_OVER_RADIO_S,
    SLOWS_WITHIN_S,
    Obedience,
    Runaways,
)
from setcmas_simu.robots.model import IDEAL, ROBOT_LIMITS


def judged(commanded, wheels, seconds=1.0, silent_from=9.9):
    """Return what the check reports of wheels with (V, omega) that are commanded otherwise."""
    obedience, step = Obedience(IDEAL), 0
    while step / 20 <= seconds:
        if step / 20 < silent_from:
            obedience.measure(*wheels, step / 20)
        verdict = obedience.update(*commanded, step / 20)
        step += 1
    return verdict


@pytest.mark.parametrize(
    ('commanded', 'wheels', 'seconds', 'expected'),
    [
        ((0.1, 0.0), (0.1, 0.0), 1.0, ''),
        ((-0.1, 0.0), (0.0, 0.0), 1.0, 'do not turn'),
        ((0.0, 1.0), (0.0, 0.0), 1.0, 'do not turn'),
        ((0.0, -1.0), (0.0, -1.0), 1.0, ''),
        ((0.1, 0.0), (0.0, 0.0), 0.6, ''),
        ((0.04, 0.0), (0.0, 0.0), 1.0, ''),
        ((0.0, 0.0), (0.0, 0.0), 1.0, ''),
        ((0.0, 0.0), (-0.1, 0.0), 1.0, 'wheels turn'),
        ((0.0, 0.0), (0.0, 0.5), 1.0, 'wheels turn'),
        ((0.0, 0.0), (0.0, 0.3), 1.0, ''),
        ((0.0, 0.0), (0.1, 0.0), 0.4, ''),
    ],
)
def test_wheels_do_what_they_are_commanded(commanded, wheels, seconds, expected):
    verdict = judged(commanded, wheels, seconds)
    assert expected in verdict if expected else not verdict


def test_a_robot_that_falls_silent_is_off_and_one_that_was_always_silent_is_unknown():
    forward = (0.1, 0.0)
    assert 'switched off' in judged(forward, forward, 2.0, silent_from=0.5)
    assert not judged(forward, forward, 2.0, silent_from=0.0)


def test_a_robot_that_is_switched_off_while_it_drives_does_not_turn_its_wheels():
    obedience = Obedience(IDEAL)
    obedience.measure(0.2, 0.0, 0.0)
    assert not obedience.update(0.0, 0.0, 0.0)
    assert not obedience.update(0.0, 0.0, 0.9)


def test_wheels_that_slow_down_have_more_time():
    obedience = Obedience(IDEAL)
    speeds = [0.2, 0.2, 0.15, *[0.1] * 30]
    verdicts = []
    for step, speed in enumerate(speeds):
        obedience.measure(speed, 0.0, step / 20)
        verdicts.append(obedience.update(0.0, 0.0, step / 20))

    assert not any(verdicts[: round(20 * RUNS_AWAY_AFTER_S)])
    assert verdicts[-1]


NOISE = [(0.001, 0.05), (-0.001, -0.08), (0.0, 0.087)]  # of encoders and a gyroscope at rest
CREEPS = (0.0, 0.3)  # the slow turn of a robot that has not proved its axes


def first_cut(wheels, commanded=((0.0, 0.0),), slows_within=SLOWS_WITHIN_S):
    """Return after how many s a burger ignores zero; wheels and commands each 20 times a second.

    The last command goes on.
    """
    obedience = Obedience(ROBOT_LIMITS['burger'], slows_within)
    for step, measured in enumerate(wheels):
        if measured:
            obedience.measure(*measured, step / 20)
        command = commanded[min(step, len(commanded) - 1)]
        if obedience.update(*command, step / 20) == IGNORES_ZERO:
            return step / 20
    return None


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


def runs_away(runaways, is_zero, seen, wheels, now, has_rival=False):
    """Return whether a robot with this forward speed (m/s) is a new runaway."""
    wheels = None if wheels is None else (wheels, 0.0)
    return runaways.update(1, is_zero, (seen, 0.0), wheels, has_rival, now)


def test_a_robot_that_does_not_stop_is_noticed_once():
    runaways = Runaways(IDEAL)

    assert not runs_away(runaways, False, 0.2, None, 1.0)
    assert not runs_away(runaways, True, 0.2, None, 0.9 * RUNS_AWAY_AFTER_S + 1.0)
    assert runs_away(runaways, True, -0.2, None, 1.1 * RUNS_AWAY_AFTER_S + 1.0)
    assert not runs_away(runaways, True, 0.19, None, 1.2 * RUNS_AWAY_AFTER_S + 1.0)
    assert runaways.robots == {1: 0.19}

    runs_away(runaways, False, 0.2, None, 8.0)
    assert runaways.robots == {}
    assert not runs_away(runaways, True, 0.2, None, 8.5)


def test_a_robot_that_came_to_rest_is_carried():
    runaways = Runaways(IDEAL)
    assert not runs_away(runaways, True, 0.3, None, 0.0)  # it was never commanded
    assert not runs_away(runaways, True, 0.3, None, 5.0)
    runs_away(runaways, False, 0.2, None, 6.0)
    runs_away(runaways, True, 0.01, None, 6.5)

    assert not runs_away(runaways, True, 0.3, None, 9.0)
    assert runaways.robots == {}


def test_a_robot_whose_wheels_show_no_more_than_noise_is_carried():
    runaways = Runaways(ROBOT_LIMITS['burger'])
    for step in range(60):
        seen = (0.5 if step > 20 else 0.0, 0.0)
        assert not runaways.update(1, True, seen, NOISE[step % 3], False, step / 20)


@pytest.mark.parametrize(('wheels', 'rival'), [(None, True), (0.0, False)])
def test_a_robot_whose_wheels_turn_again_or_that_has_a_rival_is_driven(wheels, rival):
    runaways = Runaways(IDEAL)
    for now in (0.0, 9.0, 9.1):
        assert not runs_away(runaways, True, 0.0, wheels, now, rival)

    again = None if wheels is None else 0.2
    assert not runs_away(runaways, True, 0.2, again, 9.2, rival)
    assert runs_away(runaways, True, 0.2, again, 9.3 + RUNS_AWAY_AFTER_S, rival)
