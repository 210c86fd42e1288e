import pytest

from setcmas_expe.safety.obedience import Obedience
from setcmas_simu.robots.velocity_limits import IDEAL


def judged(commanded, wheels, seconds=1.0, silent_from=9.9):
    """Return what is said of a robot with (V, omega) by its wheels, while commanded others."""
    obedience, step = Obedience(IDEAL), 0
    while step / 20 <= seconds:
        if step / 20 < silent_from:
            obedience.hear(*wheels, step / 20)
        verdict = obedience.update(*commanded, step / 20)
        step += 1
    return verdict


@pytest.mark.parametrize(
    ('commanded', 'wheels', 'seconds', 'told'),
    [
        ((0.1, 0.0), (0.1, 0.0), 1.0, ''),
        ((-0.1, 0.0), (0.0, 0.0), 1.0, 'stand'),
        ((0.0, 1.0), (0.0, 0.0), 1.0, 'stand'),
        ((0.0, -1.0), (0.0, -1.0), 1.0, ''),
        ((0.1, 0.0), (0.0, 0.0), 0.6, ''),
        ((0.04, 0.0), (0.0, 0.0), 1.0, ''),
        ((0.0, 0.0), (0.0, 0.0), 1.0, ''),
        ((0.0, 0.0), (-0.1, 0.0), 1.0, 'turn'),
        ((0.0, 0.0), (0.0, 0.5), 1.0, 'turn'),
        ((0.0, 0.0), (0.0, 0.3), 1.0, ''),
        ((0.0, 0.0), (0.1, 0.0), 0.6, ''),
    ],
)
def test_wheels_do_what_they_are_commanded(commanded, wheels, seconds, told):
    verdict = judged(commanded, wheels, seconds)
    assert told in verdict if told else not verdict


def test_a_robot_that_was_heard_and_is_silent_is_off_and_one_that_never_was_tells_nothing():
    forward = (0.1, 0.0)
    assert 'switched off' in judged(forward, forward, 2.0, silent_from=0.5)
    assert not judged(forward, forward, 2.0, silent_from=0.0)


def test_a_robot_that_is_switched_off_while_it_drives_does_not_turn_its_wheels():
    obedience = Obedience(IDEAL)
    obedience.hear(0.2, 0.0, 0.0)
    assert not obedience.update(0.0, 0.0, 0.0)
    assert not obedience.update(0.0, 0.0, 0.9)
