"""Ticks of a simulation in lockstep, and the stamps of its messages."""

from __future__ import annotations

from setcmas_simu.ros import ros_time

_FIRST_NS = 10**9  # stamp of t = 0: ROS and readers of bags take 0 for "no time"


class Ticks:
    """Clock that moves from tick to tick on command; messages of this process carry its time.

    Attributes:
        rate: Rate of the ticks in Hz.
        count: Number of the current tick, from 0.
        time: The time in s; it may be set forward between two ticks.
    """

    def __init__(self, rate: float) -> None:
        """Start at tick 0."""
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
        """Return the stamp in ns of a tick; by default of the current one."""
        return stamp_at((self.count if count is None else count) / self.rate)

    def count_of(self, stamp: int) -> int:
        """Return the number of the tick with this stamp in ns."""
        return round((stamp - _FIRST_NS) * self.rate / 1e9)


def stamp_at(t: float) -> int:
    """Return the stamp in ns of time t in s."""
    return _FIRST_NS + round(t * 1e9)
