"""Console of an experiment: messages between the terminal and the pause process."""

from __future__ import annotations

import enum
import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator

import msgspec

from setcmas_expe.bridge.bridge_decision import BridgeState
from setcmas_expe.bridge.bridge_report import BridgeReport
from setcmas_expe.bridge.machine_load import time_since_boot
from setcmas_simu.reports import LineDecoder, ProcessMessage

SILENT_AFTER_S = 0.5
"""Silence of the terminal that pauses, in s."""

OLD_AFTER_S = 1.0
"""Age of a press that was delayed between processes and starts nothing, in s."""

_CATCHES_UP_S = 0.2


class Action(enum.Enum):
    """What the operator wants."""

    PAUSE = 'pause'
    START = 'start'  # by a key or a button; repeated while that is held
    GO = 'go'  # by a command that starts robots once everything is ready
    EMERGENCY = 'emergency'
    RELEASE = 'release'  # the first or the second press that releases the stop
    HALT = 'halt'  # the bridge process has died: command zero in its place
    END = 'end'  # the experiment ends: pause, and ignore other processes that end
    ALIVE = 'alive'  # the keyboard is served; sent several times a second


_NEVER_LATE = (Action.START, Action.RELEASE)


class OperatorRequest(ProcessMessage, frozen=True):
    """A message of the terminal.

    Attributes:
        by: Key or button, such as 'by space bar'.
        pressed_at: Time in s since boot, on the clock of this machine.
    """

    action: Action
    by: str = ''
    pressed_at: float = msgspec.field(default_factory=time_since_boot)


class Status(ProcessMessage, frozen=True):
    """The pause state and a line for each robot, for the terminal."""

    paused: bool
    emergency: bool
    why: str
    robots: tuple[BridgeReport, ...]

    @property
    def is_starting(self) -> bool:
        """Whether all robots wait for the bridge alone, which rules out contradicting messages."""
        return all(robot.state is BridgeState.PAUSED and robot.ready for robot in self.robots)

    @property
    def is_moving(self) -> bool:
        """Whether a robot moves."""
        return any(robot.state is BridgeState.MOVING for robot in self.robots)


class ConsoleReader:
    """Reads requests from standard input in a thread, and hands them out without waiting.

    A press that comes after a silence, or that was made long ago, must not start anything: much
    may have happened since.
    """

    def __init__(self, on_end: Callable[[], None]) -> None:
        """Start to read; the thread calls `on_end` when the terminal's process is gone."""
        self._requests: queue.SimpleQueue[tuple[OperatorRequest, bool]] = queue.SimpleQueue()
        self._received = time.monotonic()
        self._was_silent = False
        self._on_end = on_end
        threading.Thread(target=self._read, name='console', daemon=True).start()

    def requests(self) -> Iterator[tuple[OperatorRequest, bool]]:
        """Yield the requests since the last call, and whether each came too late to count."""
        while not self._requests.empty():
            yield self._requests.get()

    @property
    def stuck(self) -> bool:
        """Whether the terminal was silent at the last check."""
        return self._was_silent

    def silent(self, now: float) -> bool:
        """Return, once, whether the terminal is silent for too long."""
        silent = now - self._received > SILENT_AFTER_S
        first, self._was_silent = silent and not self._was_silent, silent
        return first

    def _read(self) -> None:
        late_until = 0.0
        decoder: LineDecoder[OperatorRequest] = LineDecoder(OperatorRequest)
        while data := os.read(sys.stdin.fileno(), 4096):
            for request in decoder.feed(data):
                now = time.monotonic()
                if now - self._received > SILENT_AFTER_S:
                    late_until = now + _CATCHES_UP_S
                self._received = now
                old = now < late_until or time_since_boot() - request.pressed_at > OLD_AFTER_S
                self._requests.put((request, old and request.action in _NEVER_LATE))
        self._on_end()
