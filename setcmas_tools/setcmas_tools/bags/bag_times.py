"""Times of messages in a bag: of their arrival, or of their simulation."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Callable, Iterator

from setcmas_simu.fleet import topics
from setcmas_simu.ros.messages import read_stamp
from setcmas_tools.bags.recorded_topic import Received

_HELD_BACK_S = 0.3

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

    def of(self, messages: list[Received], complete: bool) -> Iterator[Timed]:
        """Yield messages with their times, in order; those yielded are taken from the list.

        Where they are complete, none is held back.
        """
        del complete
        now = self._system_ns()
        jump = now - self._steady_ns() - self._offset
        messages.sort(key=lambda message: message.time_ns)
        for message in messages:
            self._last = max(self._last, (message.time_ns or now) - jump)  # 0 is unknown
            yield self._pace(self._last), message
        messages.clear()


class StampTimes:
    """Times of a simulation in lockstep: a message's stamp, else its tick's.

    Messages of the newest tick wait for the next tick, since more may arrive; not for long, if
    time stops. What has just arrived waits in any case: the message of its tick may come with the
    next batch.
    """

    def __init__(self, steady_s: Callable[[], float] = time.monotonic) -> None:
        """Wait for the first tick; `steady_s` is a clock in s that is never set."""
        self._steady_s = steady_s
        self._last_tick_at = 0.0
        self._nb_waiting = 0
        self._sent: list[int] = []
        self._ticks: list[int] = []

    def of(self, messages: list[Received], complete: bool) -> Iterator[Timed]:
        """Yield the messages of all ticks but the newest one, as `ArrivalTimes` does."""
        for message in messages:
            if message.topic.name == topics.CLOCK:
                self._note_tick(message.sent_ns, read_stamp(message.data))
        if not self._ticks:
            return
        timed = sorted(
            ((self._time(message), message) for message in messages),
            key=lambda one: (one[0], one[1].sent_ns),
        )
        is_late = self._steady_s() - self._last_tick_at > _HELD_BACK_S
        seen = set(map(id, messages if complete else messages[: self._nb_waiting * is_late]))
        newest = self._ticks[-1]
        due = [one for one in timed if one[0] < newest or id(one[1]) in seen]
        messages[:] = [one for t, one in timed if t >= newest and id(one) not in seen]
        self._nb_waiting = len(messages)
        yield from due

    def _note_tick(self, sent_ns: int, stamp: int) -> None:
        if not self._ticks or stamp > self._ticks[-1]:
            self._sent.append(sent_ns)
            self._ticks.append(stamp)
            self._last_tick_at = self._steady_s()

    def _time(self, message: Received) -> int:
        tick = self._ticks[max(0, bisect_right(self._sent, message.sent_ns) - 1)]
        # A node that does not follow the simulation has stamps far from the tick.
        stamp = read_stamp(message.data) if message.topic.has_stamp else tick
        return stamp if 0 <= stamp - tick < 10**9 else tick


BagTimes = ArrivalTimes | StampTimes


def bag_times(rtf: float = 1.0, begin: float = 0.0, in_lockstep: bool = False) -> BagTimes:
    """Return the times for robots whose time goes by at `rtf` s per s, or in lockstep.

    It begins at `begin` s of the system's clock; in real time that clock counts.
    """
    if in_lockstep:
        return StampTimes()
    if rtf != 1.0:
        begin_ns = round(begin * 1e9)
        return ArrivalTimes(lambda ns: max(0, round((ns - begin_ns) * rtf)))
    return ArrivalTimes()
