"""Player of a bag: messages when their time comes, keys of the terminal, and status."""

from __future__ import annotations

import os
import select
import sys
import time
from collections.abc import Callable, Iterable, Mapping

from rclpy.publisher import Publisher

from setcmas_simu.reports.encoding import LineDecoder
from setcmas_simu.ros.process import RosProcess
from setcmas_tools.bags.reader import BagTopic
from setcmas_tools.player.bag_cursor import BagCursor, Played
from setcmas_tools.player.play_clock import PlayClock
from setcmas_tools.player.protocol import Key, Playing, Pressed

STEP_S = 0.1
"""What an arrow key moves: a period of the robots' odometry."""
_STATUS_S = 0.1
_LONGEST_WAIT_S = 0.025


class Player:
    """Publishes what a cursor hands out.

    Attributes:
        count: Number of messages that were published.
        on_tick: Called at least every 25 ms with the time in the recording in s; returns why
            playing must end, empty if it may go on.
    """

    def __init__(
        self,
        process: RosProcess,
        cursor: BagCursor,
        publishers: Mapping[BagTopic, Publisher],
        rate: float,
    ) -> None:
        """Stand at the cursor's place.

        Args:
            process: Asked whether to stop, and told where the player is.
            cursor: Hands out the messages.
            publishers: Where those of a topic go.
            rate: How many times as fast as they were recorded.
        """
        self.count = 0
        self.on_tick: Callable[[float], str] = lambda _: ''
        self._process = process
        self._cursor = cursor
        self._publishers = publishers
        self._clock = PlayClock(rate, 0.0, time.monotonic())
        self._next_status = 0.0
        self._keys: LineDecoder[Pressed] = LineDecoder(Pressed)
        self._stdin: int | None = sys.stdin.fileno() if sys.stdin else None

    def play(self, start: float, loop: bool) -> str:
        """Play from a time in s to the end, again and again if it is a loop.

        Returns:
            Why it ended before; empty if it came to the end, or was asked to stop.
        """
        self._move_to(start)
        while not self._process.stopping:
            now = time.monotonic()
            at = min(self._clock.at(now), self._cursor.duration)
            self._publish(self._cursor.until(at))
            if reason := self.on_tick(at):
                return reason
            self._tell(at, now)
            if self._cursor.next_s is None and not self._clock.paused:
                if not loop:
                    break
                self._move_to(start)
            self._take_keys(self._wait_s(now))
        return ''

    def _wait_s(self, now: float) -> float:
        following = self._cursor.next_s
        if self._clock.paused or following is None:
            return _LONGEST_WAIT_S
        return min(_LONGEST_WAIT_S, self._clock.wait_s(following, now))

    def _publish(self, messages: Iterable[Played]) -> None:
        for topic, data in messages:
            self._publishers[topic].publish(data)
            self.count += 1
            if self._process.stopping:
                return

    def _move_to(self, at: float) -> None:
        """Go to a time in s; what is latched by then, and the step before, is published."""
        now = time.monotonic()
        self._publish(self._cursor.move_to(max(0.0, at - STEP_S)))
        self._publish(self._cursor.until(at))
        self._clock.move_to(at, now)

    def _tell(self, at: float, now: float) -> None:
        if now >= self._next_status:
            self._next_status = now + _STATUS_S
            status = Playing(at, self._cursor.duration, self._clock.paused)
            self._process.launcher.tell(status)

    def _take_keys(self, timeout_s: float) -> None:
        """Wait for a time, and no longer than until a key is pressed."""
        if self._stdin is None:
            time.sleep(timeout_s)
        elif select.select([self._stdin], [], [], timeout_s)[0]:
            data = os.read(self._stdin, 4096)
            if not data:  # no terminal
                self._stdin = None
            for pressed in self._keys.feed(data):
                self._act(pressed.key)

    def _act(self, key: Key) -> None:
        now = time.monotonic()
        if key is Key.TOGGLE:
            self._clock.toggle(now)
            return
        at = self._clock.at(now)
        if not self._clock.paused:
            self._clock.toggle(now)
        if key is Key.BACK:
            self._move_to(max(0.0, at - STEP_S))
        else:
            self._clock.move_to(min(at + STEP_S, self._cursor.duration), now)
