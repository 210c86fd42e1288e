import pytest

from setcmas_expe.doctor.lab.arrival_statistics import arrival_statistics


def test_regular_messages():
    arrivals = [10.0 + 0.02 * i for i in range(101)]
    statistics = arrival_statistics(arrivals, [t - 0.005 for t in arrivals], 10.0, 12.0)

    assert statistics.rate == pytest.approx(50.0)
    assert statistics.jitter == pytest.approx(0.0, abs=1e-9)
    assert statistics.largest_gap == pytest.approx(0.02)
    assert statistics.age == pytest.approx(0.005)


def test_jitter_and_a_gap():
    statistics = arrival_statistics([0.0, 0.1, 0.4, 0.5], [0.0] * 4, 0.0, 0.5)

    assert statistics.rate == pytest.approx(6.0)
    assert statistics.largest_gap == pytest.approx(0.3)
    assert statistics.jitter == pytest.approx(0.0943, abs=1e-3)


def test_a_source_that_falls_silent_has_a_gap_up_to_the_end():
    assert arrival_statistics([0.0, 0.1], [0.0, 0.0], 0.0, 3.0).largest_gap == pytest.approx(2.9)


def test_nothing_at_all():
    statistics = arrival_statistics([], [], 0.0, 3.0)

    assert (statistics.rate, statistics.age, statistics.largest_gap) == (0.0, None, 3.0)


@pytest.mark.parametrize('difference', [-60.0, 60.0])
def test_clocks_that_differ_give_no_age(difference):
    arrivals = [1000.0, 1000.1]

    assert arrival_statistics(arrivals, [t - difference for t in arrivals], 999, 1001).age is None
