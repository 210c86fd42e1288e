import pytest

pytest.importorskip('rclpy')

from setcmas_expe.pause.joystick import Joystick

UP, DOWN = [0] * 8, [0] * 7 + [1]


def test_only_going_down_counts():
    joystick = Joystick()
    messages = [UP, DOWN, DOWN, UP, [1] * 8]

    pressed = [set(joystick.pressed(m, t / 20)) for t, m in enumerate(messages)]
    assert pressed == [set(), {7}, set(), set(), set(range(8))]


def test_a_button_that_is_down_at_first_is_not_held_until_it_goes_down_again():
    joystick = Joystick()
    held = []
    for t, message in enumerate([DOWN, DOWN, UP, DOWN]):
        joystick.pressed(message, t / 20)
        held.append(set(joystick.held))

    assert held == [set(), set(), set(), {7}]


def test_a_joystick_that_comes_back_with_its_button_down_does_not_start_robots():
    joystick = Joystick()
    joystick.pressed(UP, 0.0)
    joystick.disappeared(1.0)

    assert not joystick.pressed(DOWN, 2.0)
