from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from setcmas_tools.bags.bag_times import ArrivalTimes, StampTimes, bag_times
from setcmas_tools.bags.recorded_topic import Received

S = 1_000_000_000


def message(name, sent_ns, stamp=None):
    topic = SimpleNamespace(name=name, has_stamp=stamp is not None)
    seconds, nanoseconds = divmod(stamp or 0, S)
    data = b'\0\1\0\0' + seconds.to_bytes(4, 'little') + nanoseconds.to_bytes(4, 'little')
    return Received(sent_ns, sent_ns, topic, data)


def timed(times, messages, complete=False):
    return [(t, one.topic.name) for t, one in times.of(messages, complete)]


def test_in_lockstep_the_time_is_that_of_the_stamp_or_of_the_tick():
    times = bag_times(in_lockstep=True)
    waiting = [
        message('/tb3_1/cmd_cart_vel', 60),
        message('/clock', 50, 1 * S),
        message('/task', 10),
        message('/foreign', 55, 1_700_000_000 * S),
    ]
    assert timed(times, waiting) == []
    waiting += [
        message('/tb3_1/odom', 80, 1 * S + S // 10),
        message('/clock', 70, 1 * S + S // 10),
        message('/tb3_1/odom', 52, 1 * S),
    ]

    assert timed(times, waiting) == [
        (S, '/task'),
        (S, '/clock'),
        (S, '/tb3_1/odom'),
        (S, '/foreign'),
        (S, '/tb3_1/cmd_cart_vel'),
    ]
    assert timed(times, waiting, complete=True) == [
        (S + S // 10, '/clock'),
        (S + S // 10, '/tb3_1/odom'),
    ]
    assert waiting == []


def test_a_time_that_goes_faster_is_that_of_the_bag():
    times = bag_times(5.0, begin=100.0)

    (first, b), (second, a) = timed(times, [message('/a', 102 * S), message('/b', 101 * S)])
    assert (b, a) == ('/b', '/a')
    assert (first, second) == pytest.approx((5 * S, 10 * S), abs=S // 100)


def test_while_time_is_paused_the_newest_state_is_not_held_back():
    now = 5.0
    times = StampTimes(lambda: now)
    waiting = [message('/clock', 50, S), message('/tb3_1/odom', 60, S)]

    assert timed(times, waiting) == []
    now = 6.0
    assert timed(times, waiting) == [(S, '/clock'), (S, '/tb3_1/odom')]


def test_a_message_that_arrives_before_that_of_its_tick_waits_for_it_also_on_a_slow_machine():
    now = 5.0
    times = StampTimes(lambda: now)
    waiting = [message('/clock', 50, S), message('/tb3_1/odom', 60, S)]
    timed(times, waiting)
    now = 6.0
    waiting.append(message('/tb3_1/trig_event', 80))

    assert timed(times, waiting) == [(S, '/clock'), (S, '/tb3_1/odom')]
    waiting += [message('/clock', 70, 2 * S), message('/clock', 90, 3 * S)]
    assert timed(times, waiting) == [(2 * S, '/clock'), (2 * S, '/tb3_1/trig_event')]


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
            yield next(times.of([message('/a', time_ns)], False))[0]


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
