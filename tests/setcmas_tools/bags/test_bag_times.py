from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from setcmas_tools.bags.bag_times import ArrivalTimes, bag_times
from setcmas_tools.bags.recorded_topic import Received

S = 1_000_000_000


def message(name, time_ns):
    return Received(time_ns, SimpleNamespace(name=name), b'')


def timed(times, messages):
    return [(t, one.topic.name) for t, one in times.of(messages)]


def test_a_time_that_goes_faster_is_that_of_the_bag():
    times = bag_times(5.0, begin=100.0)

    (first, b), (second, a) = timed(times, [message('/a', 102 * S), message('/b', 101 * S)])
    assert (b, a) == ('/b', '/a')
    assert (first, second) == pytest.approx((5 * S, 10 * S), abs=S // 100)


class Clocks:
    """A system clock that is set, and a steady one."""

    def __init__(self):
        self.system = 1_000_000
        self.steady = 500

    def pass_time(self, duration):
        self.system += duration
        self.steady += duration

    def times(self, *received):
        times = ArrivalTimes(int, lambda: self.system, lambda: self.steady)
        yield
        for time_ns in received:
            yield next(times.of([message('/a', time_ns)]))[0]


def test_times_of_arrival_are_kept_and_never_go_back():
    clocks = Clocks()
    times = clocks.times(1_000_020, 1_000_010, 1_000_050)
    next(times)
    clocks.pass_time(100)

    assert list(times) == [1_000_020, 1_000_020, 1_000_050]


@pytest.mark.parametrize('jump', [3600, -3600])
def test_setting_the_clock_does_not_move_the_recording(jump):
    clocks = Clocks()
    times = clocks.times(clocks.system + 100 + jump)
    next(times)
    clocks.pass_time(100)
    clocks.system += jump

    assert next(times) == 1_000_100


def test_unknown_times_are_now():
    clocks = Clocks()
    times = clocks.times(0)
    next(times)
    clocks.pass_time(7)

    assert next(times) == 1_000_007
