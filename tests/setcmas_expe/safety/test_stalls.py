import time

import pytest

from setcmas_expe.safety.stalls import HoldUps, time_since_boot


def test_regular_signs_of_life_are_no_hold_up():
    hold_ups = HoldUps(0.5, 100.0)

    assert [hold_ups.live(100.0 + 0.4 * i) for i in range(1, 20)] == [0.0] * 19
    assert not hold_ups.recent(108.0)


def test_a_gap_is_told_once_and_what_comes_in_after_it_is_not_trusted_for_a_while():
    hold_ups = HoldUps(0.5, 100.0)

    assert hold_ups.recent(103.0)  # before the first sign of life after it, too
    assert hold_ups.live(103.0) == 3.0
    assert hold_ups.live(103.1) == 0.0
    assert hold_ups.live(103.5) == 0.0
    assert hold_ups.recent(103.9)
    assert hold_ups.live(103.9) == 0.0
    assert not hold_ups.recent(104.1)


@pytest.mark.skipif(not hasattr(time, 'CLOCK_BOOTTIME'), reason='of Linux alone')
def test_the_clock_goes_on_while_the_machine_sleeps(monkeypatch):
    monkeypatch.setattr(time, 'clock_gettime', lambda clock: clock)

    assert time_since_boot() == time.CLOCK_BOOTTIME
