from setcmas_expe.pause.start_requests import REACTION_S, REPEATS_WITHIN_S, StartRequests


def test_a_go_is_meant_once():
    requests = StartRequests(0.0)
    now = REPEATS_WITHIN_S
    assert not requests.repeated(False, now)
    assert not requests.repeated(True, now + 1.0)
    assert requests.repeated(False, now + 2.0)
    assert requests.repeated(False, now + 4.0)
    assert not requests.repeated(False, now + 4.0 + REPEATS_WITHIN_S)


def test_a_go_at_the_beginning_was_not_meant_for_this_experiment():
    assert StartRequests(5.0).repeated(False, 5.0 + 0.9 * REPEATS_WITHIN_S)


def test_a_key_that_is_held_down_does_not_start():
    requests = StartRequests(0.0)
    assert not requests.hasty(10.0)
    assert requests.hasty(10.0 + 0.9 * REACTION_S)  # keyboards repeat after half a second
    assert all(requests.hasty(11.0 + step / 30) for step in range(300))
    assert not requests.hasty(22.1 + REACTION_S)


def test_a_toggle_that_crosses_a_pause_that_came_by_itself_is_no_start():
    requests = StartRequests(0.0)
    requests.note_pause(True, 1.0)
    assert requests.hasty(1.0 + 0.9 * REACTION_S)
    assert not requests.hasty(1.0 + 2.0 * REACTION_S)
    requests.note_pause(True, 5.0)
    requests.note_pause(False, 5.1)
    assert not requests.hasty(5.2)
