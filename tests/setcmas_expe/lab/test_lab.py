import math

import pytest

from setcmas_expe.lab.lab import BatteryScale


def test_a_battery_is_shown_in_percent_whatever_its_scale():
    share, percent = BatteryScale(), BatteryScale()

    assert share.percent(0.04) == pytest.approx(4.0)
    assert share.percent(1.0) == 100.0
    assert percent.percent(87.0) == 87.0
    assert percent.percent(0.9) == 0.9  # the robot has sent percentages
    assert share.percent(math.nan) is None
