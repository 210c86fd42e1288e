from setcmas_tools.recorder.receive_clock import ReceiveClock


class Clocks:
    """A system clock that somebody sets, and one that nobody sets."""

    def __init__(self):
        self.system = 1_000_000
        self.steady = 500

    def pass_time(self, duration):
        self.system += duration
        self.steady += duration

    def clock(self):
        return ReceiveClock(lambda: self.system, lambda: self.steady)


def test_times_of_arrival_are_kept():
    clocks = Clocks()
    clock = clocks.clock()
    clocks.pass_time(100)
    clock.update()

    assert [clock.stamp(t) for t in (1_000_020, 1_000_050)] == [1_000_020, 1_000_050]


def test_times_never_go_back():
    clock = Clocks().clock()

    assert [clock.stamp(t) for t in (50, 40, 60)] == [50, 50, 60]


def test_setting_the_clock_does_not_move_the_recording():
    for jump in (3600, -3600):
        clocks = Clocks()
        clock = clocks.clock()
        clock.stamp(clocks.system)
        clocks.pass_time(100)
        clocks.system += jump
        clock.update()

        assert clock.stamp(clocks.system) == 1_000_100


def test_unknown_times_are_now():
    clocks = Clocks()
    clock = clocks.clock()
    clocks.pass_time(7)

    assert clock.stamp(0) == 1_000_007
