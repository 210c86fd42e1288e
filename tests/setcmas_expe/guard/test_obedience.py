import pytest

from setcmas_expe.guard.obedience import RUNS_AWAY_AFTER_S, Obedience, Runaways
from setcmas_simu.robots.model import IDEAL


def judged(commanded, wheels, seconds=1.0, silent_from=9.9):
    """Return what is said of a robot with (V, omega) by its wheels, while commanded others."""
    obedience, step = Obedience(IDEAL), 0
    while step / 20 <= seconds:
        if step / 20 < silent_from:
            obedience.measure(*wheels, step / 20)
        verdict = obedience.update(*commanded, step / 20)
        step += 1
    return verdict


@pytest.mark.parametrize(
    ('commanded', 'wheels', 'seconds', 'told'),
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
def test_wheels_do_what_they_are_commanded(commanded, wheels, seconds, told):
    verdict = judged(commanded, wheels, seconds)
    assert told in verdict if told else not verdict


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


def test_a_robot_that_does_not_stop_is_noticed_once():
    runaways = Runaways()

    assert not runaways.update(2, False, 0.2, False, 1.0)  # it is commanded to move
    assert not runaways.update(
        2, True, 0.2, False, 0.9 * RUNS_AWAY_AFTER_S + 1.0
    )  # it needs its time
    assert runaways.update(2, True, -0.2, False, 1.1 * RUNS_AWAY_AFTER_S + 1.0)
    assert not runaways.update(2, True, 0.19, False, 1.2 * RUNS_AWAY_AFTER_S + 1.0)
    assert runaways.robots == {2: 0.19}

    runaways.update(2, False, 0.2, False, 8.0)
    assert runaways.robots == {}
    assert not runaways.update(2, True, 0.2, False, 8.5)


def test_a_robot_that_came_to_rest_is_carried():
    runaways = Runaways()
    assert not runaways.update(1, True, 0.3, False, 0.0)  # it was never commanded
    assert not runaways.update(1, True, 0.3, False, 5.0)
    runaways.update(1, False, 0.2, False, 6.0)
    runaways.update(1, True, 0.01, False, 6.5)

    assert not runaways.update(1, True, 0.3, False, 9.0)
    assert runaways.robots == {}


def test_a_robot_that_another_node_commands_is_not_carried():
    runaways = Runaways()
    assert not runaways.update(1, True, 0.0, True, 0.0)

    assert runaways.update(1, True, 0.2, True, 2 * RUNS_AWAY_AFTER_S)


def test_a_robot_that_came_to_rest_and_whose_wheels_turn_again_is_driven():
    runaways = Runaways()
    assert not runaways.update(1, True, 0.0, True, 0.0)
    assert not runaways.update(1, True, 0.0, True, 9.0)
    assert not runaways.update(1, True, 0.2, True, 9.1)

    assert runaways.update(1, True, 0.2, True, 9.1 + RUNS_AWAY_AFTER_S)
