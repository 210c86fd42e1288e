import pytest

from setcmas_expe.safety.obedience import Obedience


def judged(V, wheels, seconds=1.0, silent_from=9.9):
    """Return what is said of wheels that turn at a speed while a robot is commanded another."""
    obedience, step = Obedience(), 0
    while step / 20 <= seconds:
        if step / 20 < silent_from:
            obedience.hear(wheels, step / 20)
        verdict = obedience.update(V, V == 0.0, step / 20)
        step += 1
    return verdict


@pytest.mark.parametrize(
    ('V', 'wheels', 'seconds', 'told'),
    [
        (0.1, 0.1, 1.0, ''),
        (-0.1, 0.0, 1.0, 'stand'),
        (0.1, 0.0, 0.6, ''),
        (0.04, 0.0, 1.0, ''),
        (0.0, 0.0, 1.0, ''),
        (0.0, -0.1, 1.0, 'turn'),
        (0.0, 0.1, 0.6, ''),
    ],
)
def test_wheels_do_what_they_are_commanded(V, wheels, seconds, told):
    verdict = judged(V, wheels, seconds)
    assert told in verdict if told else not verdict


def test_a_robot_that_was_heard_and_is_silent_is_off_and_one_that_never_was_tells_nothing():
    assert 'switched off' in judged(0.1, 0.1, 2.0, silent_from=0.5)
    assert not judged(0.1, 0.1, 2.0, silent_from=0.0)


def test_a_robot_that_is_switched_off_while_it_drives_does_not_turn_its_wheels():
    obedience = Obedience()
    obedience.hear(0.2, 0.0)
    assert not obedience.update(0.0, True, 0.0)
    assert not obedience.update(0.0, True, 0.9)
