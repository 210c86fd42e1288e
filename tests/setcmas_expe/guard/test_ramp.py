import pytest

from setcmas_expe.guard.ramp import ramped
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS

BURGER = ROBOT_MODELS['burger']


def test_speed_is_gained_step_by_step_up_to_the_limit_and_lost_at_once():
    speeds, followed = [], (0.0, 0.0)
    for wanted in [(9.0, 0.0)] * 4 + [(0.0, 0.0), (-0.2, 0.0)]:
        followed = ramped(wanted, followed, BURGER, gain=0.1)
        speeds.append(followed[0])
    assert speeds == pytest.approx([0.1, 0.2, BURGER.V_max, BURGER.V_max, 0.0, -0.1])


def test_a_curve_is_kept():
    V, omega = ramped((0.2, 1.0), (0.0, 0.0), BURGER, gain=0.07)
    assert omega / V == pytest.approx(5.0)
    assert V + 0.5 * BURGER.wheel_separation * omega == pytest.approx(0.07)
