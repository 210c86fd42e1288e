import pytest

pytest.importorskip('rclpy')

from setcmas_simu.ros.clocks import ScaledClock
from setcmas_simu.ros.messages import seconds_of


def test_a_scaled_clock_is_that_of_stamps_too():
    clock = ScaledClock(5.0, begin=0.0)
    before, stamp, after = clock.now(), seconds_of(clock.stamp()), clock.now()

    assert before - 1e-9 <= stamp <= after + 1e-9
    assert before > 5e9 / 2  # five times the seconds since 1970, not those of the system
