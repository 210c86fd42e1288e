from setcmas_expe.pause.joystick import Joystick

UP, DOWN = [0] * 8, [0] * 7 + [1]


def test_only_going_down_counts():
    joystick = Joystick(7)
    messages = [UP, DOWN, DOWN, UP, DOWN]

    assert [joystick.pressed(m, t / 20) for t, m in enumerate(messages)] == [
        False, True, False, False, True,
    ]  # fmt: skip


def test_a_button_that_is_down_at_first_does_not_start_robots():
    joystick = Joystick(7)

    assert not joystick.pressed(DOWN, 0.0)
    assert not joystick.pressed(DOWN, 0.05)


def test_too_few_buttons_are_noticed():
    joystick = Joystick(7)

    assert not joystick.pressed([1, 1], 0.0)
    assert joystick.missing_button


def test_a_joystick_that_goes_silent_is_told_once():
    joystick = Joystick(7)
    assert not joystick.disappeared(100.0)  # it was never there
    joystick.pressed(UP, 100.0)

    assert [joystick.disappeared(t) for t in (100.4, 100.6, 100.7)] == [False, True, False]


def test_a_joystick_that_comes_back_with_its_button_down_does_not_start_robots():
    joystick = Joystick(7)
    joystick.pressed(UP, 0.0)
    joystick.disappeared(1.0)

    assert not joystick.pressed(DOWN, 2.0)
