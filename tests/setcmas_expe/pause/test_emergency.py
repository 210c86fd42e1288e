from setcmas_expe.pause.emergency import RELEASES_WITHIN_S, Emergency
from setcmas_expe.pause.start_requests import REPEATS_WITHIN_S


def test_an_emergency_stop_is_released_by_two_presses_only():
    emergency = Emergency()
    assert emergency.stop('by Esc')
    assert not emergency.stop('by joystick')
    assert not emergency.release(1.0)
    assert not emergency.release(1.1 + RELEASES_WITHIN_S)
    assert emergency.why == 'by Esc'
    assert emergency.release(2.0 + RELEASES_WITHIN_S)
    assert emergency.why == ''


def test_a_stop_between_the_two_presses_holds():
    emergency = Emergency()
    emergency.stop('by Esc')
    emergency.release(1.0)
    emergency.stop('by /emergency_stop')

    assert not emergency.release(1.5)


def test_a_key_that_is_held_down_releases_nothing():
    emergency = Emergency()
    emergency.stop('by Esc')
    for wait in (0.25, 0.5, 0.66):  # until keyboards repeat
        begin = 10.0 * wait
        presses = [begin, *(begin + wait + step / 30 for step in range(30))]
        assert not any(map(emergency.release, presses))
        assert not emergency.release(presses[-1] + 1.1)  # one press by itself
        assert not emergency.release(presses[-1] + 1.2 + RELEASES_WITHIN_S)
    assert emergency.release(presses[-1] + 1.3 + RELEASES_WITHIN_S + REPEATS_WITHIN_S)


def test_a_guard_that_has_not_heard_of_the_release_yet_does_not_renew_it():
    emergency = Emergency()
    assert emergency.take_over('that a guard holds', 0.0)
    emergency.release(1.0)
    assert not emergency.take_over('that a guard holds', 1.5)
    assert emergency.release(2.0)
    assert not emergency.take_over('that a guard holds', 2.5)
    assert emergency.take_over('that a guard holds', 5.0)
