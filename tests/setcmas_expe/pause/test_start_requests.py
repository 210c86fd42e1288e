from setcmas_expe.pause.start_requests import REACTION_S, REPEATS_WITHIN_S, StartWishes


def test_a_go_is_meant_once():
    wishes = StartWishes(0.0)
    now = REPEATS_WITHIN_S
    assert not wishes.repeated(False, now)
    assert not wishes.repeated(True, now + 1.0)
    assert wishes.repeated(False, now + 2.0)
    assert wishes.repeated(False, now + 4.0)
    assert not wishes.repeated(False, now + 4.0 + REPEATS_WITHIN_S)


def test_a_go_at_the_beginning_was_not_meant_for_this_experiment():
    assert StartWishes(5.0).repeated(False, 5.0 + 0.9 * REPEATS_WITHIN_S)


def test_a_key_that_is_held_down_does_not_start():
    wishes = StartWishes(0.0)
    assert not wishes.hasty(10.0)
    assert wishes.hasty(10.0 + 0.9 * REACTION_S)  # keyboards repeat after half a second
    assert all(wishes.hasty(11.0 + step / 30) for step in range(300))
    assert not wishes.hasty(22.1 + REACTION_S)


def test_a_toggle_that_crosses_a_pause_that_came_by_itself_is_no_start():
    wishes = StartWishes(0.0)
    wishes.note_pause(True, 1.0)
    assert wishes.hasty(1.0 + 0.9 * REACTION_S)
    assert not wishes.hasty(1.0 + 2.0 * REACTION_S)
    wishes.note_pause(True, 5.0)
    wishes.note_pause(False, 5.1)
    assert not wishes.hasty(5.2)
