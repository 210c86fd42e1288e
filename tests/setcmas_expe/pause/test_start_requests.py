from setcmas_expe.pause.start_requests import (
    REACTION_S,
    RELEASED_AFTER_S,
    REPEATS_WITHIN_S,
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
