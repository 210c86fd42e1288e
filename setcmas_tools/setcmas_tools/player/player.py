"""Player of a bag: publishes its messages in time, and pauses on request."""

from __future__ import annotations

import os
import select
import sys
import time
from collections.abc import Callable, Iterable, Mapping

from rclpy.publisher import Publisher

from setcmas_simu.reports.reports import LineDecoder
from setcmas_simu.ros.process import RosProcess
from setcmas_tools.bags.reader import BagTopic
from setcmas_tools.player.bag_cursor import BagCursor, Played
from setcmas_tools.player.play_clock import PauseToggled, PlayClock

_BEFORE_START_S = 0.1  # a period of the robots' odometry
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
        """Prepare to play from the start of the recording.

        Args:
            process: Says when to stop.
            cursor: Reads the messages.
            publishers: The publisher of each topic.
            rate: Playback speed; 1 is as recorded.
        """
        self.count = 0
        self.on_tick: Callable[[float], str] = lambda _: ''
        self._process = process
        self._cursor = cursor
        self._publishers = publishers
        self._clock = PlayClock(rate, 0.0, time.monotonic())
        self._keys: LineDecoder[PauseToggled] = LineDecoder(PauseToggled)
        self._stdin: int | None = sys.stdin.fileno() if sys.stdin else None

    def play(self, start: float, loop: bool) -> str:
        """Play from a time in s to the end, repeatedly if `loop`.

        Returns:
            Why playing broke off; empty at the end of the bag, or after a request to stop.
        """
        self._move_to(start)
        while not self._process.stopping:
            now = time.monotonic()
            at = min(self._clock.at(now), self._cursor.duration)
            self._publish(self._cursor.until(at))
            if reason := self.on_tick(at):
                return reason
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
        """Go to a time in s; publish what is latched by then, and the robots' last poses."""
        now = time.monotonic()
        self._publish(self._cursor.move_to(max(0.0, at - _BEFORE_START_S)))
        self._publish(self._cursor.until(at))
        self._clock.move_to(at, now)

    def _take_keys(self, timeout_s: float) -> None:
        """Wait for a time in s, or until a key is pressed."""
        if self._stdin is None:
            time.sleep(timeout_s)
        elif select.select([self._stdin], [], [], timeout_s)[0]:
            data = os.read(self._stdin, 4096)
            if not data:  # no terminal
                self._stdin = None
            for _ in self._keys.feed(data):
                self._toggle_pause()

    def _toggle_pause(self) -> None:
        now = time.monotonic()
        self._clock.toggle(now)
        state = 'paused' if self._clock.paused else 'playing on'
        print(f'{state} at {self._clock.at(now):.1f} s', flush=True)
