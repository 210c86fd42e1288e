import pytest

from setcmas_expe.mocap.arrivals import Arrivals


def came(*gaps):
    arrivals, now = Arrivals(), 5.0
    arrivals.add(now)
    for gap in gaps:
        now += gap
        assert arrivals.add(now) == pytest.approx(gap)
    return arrivals


def test_one_long_gap_is_a_hiccup_and_two_in_a_row_are_a_slow_system():
    assert not came(0.02, 0.02, 0.4, 0.02, 0.4).are_slow
    assert came(0.02, 0.5, 0.5).are_slow
    assert not came(0.5, 0.5, 0.02).are_slow


def test_the_rate_is_that_of_the_usual_gap():
    assert came(0.02, 0.02, 3.0, 0.02).rate == pytest.approx(50.0)
    assert came(0.5, 0.5, 0.5).rate == pytest.approx(2.0)
