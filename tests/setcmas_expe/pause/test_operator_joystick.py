from setcmas_expe.pause.operator_joystick import Joystick

UP, DOWN = [0] * 8, [0] * 7 + [1]


def test_only_going_down_counts():
    joystick = Joystick()
    messages = [UP, DOWN, DOWN, UP, [1] * 8]

    pressed = [set(joystick.pressed(m, t / 20)) for t, m in enumerate(messages)]
    assert pressed == [set(), {7}, set(), set(), set(range(8))]


def test_a_button_that_is_down_at_first_is_neither_pressed_nor_held():
    joystick = Joystick()

    for t in (0.0, 0.05):
        assert not joystick.pressed(DOWN, t)
        assert not joystick.held
    joystick.pressed(UP, 0.1)
    joystick.pressed(DOWN, 0.15)
    assert joystick.held == {7}


def test_a_joystick_that_goes_silent_is_reported_once():
    joystick = Joystick()
    assert not joystick.disappeared(100.0)  # it was never there
    joystick.pressed(UP, 100.0)

    assert [joystick.disappeared(t) for t in (100.4, 100.6, 100.7)] == [False, True, False]


def test_a_joystick_that_comes_back_with_its_button_down_does_not_start_robots():
    joystick = Joystick()
    joystick.pressed(UP, 0.0)
    joystick.disappeared(1.0)

    assert not joystick.pressed(DOWN, 2.0)
