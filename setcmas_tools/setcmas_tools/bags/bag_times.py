"""Times of messages in a bag: of their arrival, or of their simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

from setcmas_tools.bags.recorded_topic import Received

Timed = tuple[int, Received]
"""A time in ns, and the message that has it."""


class ArrivalTimes:
    """Times of arrival, possibly scaled.

    They start on the system's clock, but do not follow when it is set during a recording:
    a jump of an hour would otherwise freeze or stretch the recorded run.
    """

    def __init__(
        self,
        pace: Callable[[int], int] = int,
        system_ns: Callable[[], int] = time.time_ns,
        steady_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """Start; `pace` converts a time in ns to that of the bag, a steady clock is never set."""
        self._pace = pace
        self._system_ns = system_ns
        self._steady_ns = steady_ns
        self._offset = system_ns() - steady_ns()
        self._last = 0

    def of(self, messages: list[Received]) -> Iterator[Timed]:
        """Yield messages with their times, in order, and take them from the list."""
        now = self._system_ns()
        jump = now - self._steady_ns() - self._offset
        messages.sort(key=lambda message: message.time_ns)
        for message in messages:
            self._last = max(self._last, (message.time_ns or now) - jump)  # 0 is unknown
            yield self._pace(self._last), message
        messages.clear()


def bag_times(rtf: float, begin: float) -> ArrivalTimes:
    """Return the times for robots with a real-time factor, and time 0 in s of the system."""
    if rtf == 1.0:
        return ArrivalTimes()
    begin_ns = round(begin * 1e9)
    return ArrivalTimes(lambda ns: max(0, round((ns - begin_ns) * rtf)))
