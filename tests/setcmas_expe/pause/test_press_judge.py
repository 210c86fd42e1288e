from setcmas_expe.pause.press_judge import (
    REACTION_S,
    RELEASED_AFTER_S,
    RELEASES_WITHIN_S,
    REPEATS_WITHIN_S,
    Emergency,
    HeldStart,
    StartRequests,
)


def test_a_key_that_is_held_down_does_not_start():
    requests = StartRequests()
    assert not requests.hasty(10.0)
    assert requests.hasty(10.0 + 0.9 * REACTION_S)  # keyboards repeat after half a second
    assert all(requests.hasty(11.0 + step / 30) for step in range(300))
    assert not requests.hasty(22.1 + REACTION_S)


def test_a_press_that_crosses_a_pause_that_came_by_itself_is_no_start():
    requests = StartRequests()
    requests.note_pause(True, 1.0)
    assert requests.hasty(1.0 + 0.9 * REACTION_S)
    assert not requests.hasty(1.0 + 2.0 * REACTION_S)
    requests.note_pause(True, 5.0)
    requests.note_pause(False, 5.1)
    assert not requests.hasty(5.2)


def test_only_a_key_that_is_held_starts_and_only_until_it_is_released():
    held = HeldStart()
    assert not held.pressed(1.0)
    assert held.pressed(1.0 + 0.9 * REPEATS_WITHIN_S)
    assert held.pressed(1.8)
    for step in range(1, 100):
        assert not held.released(1.8 + 0.1 * step)
        assert held.pressed(1.8 + 0.1 * step)
    held = HeldStart()
    assert [held.pressed(at) for at in (1.0, 1.7, 1.8)] == [False, True, True]
    assert not held.released(1.8 + 0.9 * RELEASED_AFTER_S)
    assert held.released(1.8 + 1.1 * RELEASED_AFTER_S)
    assert not held.pressed(1.9 + REPEATS_WITHIN_S)


def test_who_holds_on_when_robots_stop_by_themselves_has_to_let_go_first():
    held = HeldStart()
    assert [held.pressed(t / 30) for t in range(3)] == [False, True, True]
    held.note_pause(0.1)
    assert not any(held.pressed(t / 30) for t in range(3, 300))
    assert not held.pressed(10.0 + REPEATS_WITHIN_S)
    assert held.pressed(10.1 + REPEATS_WITHIN_S)


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


def test_a_guard_that_has_not_received_the_release_yet_does_not_renew_the_stop():
    emergency = Emergency()
    assert emergency.take_over('that a guard holds', 0.0)
    emergency.release(1.0)
    assert not emergency.take_over('that a guard holds', 1.5)
    assert emergency.release(2.0)
    assert not emergency.take_over('that a guard holds', 2.5)
    assert emergency.take_over('that a guard holds', 5.0)
