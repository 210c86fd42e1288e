"""Ticks of a simulation in lockstep, and the stamps of its messages."""

from __future__ import annotations

from setcmas_simu.ros import ros_time

_FIRST_NS = 10**9  # of t = 0: to ROS, and to readers of bags, 0 is no time


class Ticks:
    """A clock that goes from tick to tick when it is told to; messages of this process bear it.

    Attributes:
        rate: Rate of the ticks in Hz.
        count: Number of the tick that is now, from 0.
        time: The time in s; between two ticks it may be set forth.
    """

    def __init__(self, rate: float) -> None:
        """Begin at tick 0."""
        self.rate = rate
        self.count = 0
        self.time = 0.0
        ros_time.now_ns = lambda: stamp_at(self.time)

    def now(self) -> float:
        """Return the time in s."""
        return self.time

    def go_to(self, count: int) -> None:
        """Go to a tick by its number."""
        self.count = count
        self.time = count / self.rate

    def stamp(self, count: int | None = None) -> int:
        """Return the stamp in ns of a tick; of the one that is now by default."""
        return stamp_at((self.count if count is None else count) / self.rate)

    def count_of(self, stamp: int) -> int:
        """Return the number of the tick that has a stamp in ns."""
        return round((stamp - _FIRST_NS) * self.rate / 1e9)


def stamp_at(t: float) -> int:
    """Return the stamp in ns of what happens at t s."""
    return _FIRST_NS + round(t * 1e9)
