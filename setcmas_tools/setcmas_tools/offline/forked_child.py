"""Child of a host: a process that does some work, seen from outside."""

from __future__ import annotations

import shutil
import signal
import socket
import time
from collections.abc import Collection
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from setcmas_tools.offline.child_channel import (
    LOOK_S,
    Channel,
    ChannelError,
    LateError,
    MachineError,
)
from setcmas_tools.offline.fork_server import END, WAIT, last_places, places_size

_PLACE_S = 2.0  # a process that waits for a core answers late
_MOST_WAITED_S = 600.0


class EndedError(Exception):
    """A child has ended; the message gives the reason.

    Attributes:
        status: Its exit status, or the number of the signal that killed it, negative.
        places: Files and lines of its last calls, the innermost first.
        was_ended: Whether the host ended it, as it was late or took too much.
    """

    def __init__(
        self, message: str, status: int, places: list[tuple[Path, int]], was_ended: bool = True
    ) -> None:
        super().__init__(message)
        self.status = status
        self.places = places
        self.was_ended = was_ended


class Parent(Protocol):
    """The host of a child."""

    is_isolated: bool

    def ask_place(self, process: int) -> bool:
        """Let a child write its current calls; return whether it can."""

    def end_child(self, child: Child, order: bytes) -> int:
        """End a child and all its processes; return its exit status."""

    def has_failed(self, child: Child) -> bool:
        """Return whether the machine, not the script, has ended a child."""

    def check_amounts(self) -> None:
        """Raise ChannelError if the children together use too much."""


class Child:
    """A process that does some work; use as a context manager, which ends it.

    Attributes:
        has_begun: Whether its work has begun, as far as received messages show.
    """

    def __init__(
        self, host: Parent, process: int, folder: Path, end: socket.socket, most: int
    ) -> None:
        """Connect to a child that `Host.begin` has started.

        Args:
            host: Its host.
            process: Its process ID.
            folder: Its folder.
            end: The connection.
            most: Size of the longest message that it may send, in bytes.
        """
        self.process = process
        self.folder = folder
        self.has_begun = False
        self._host = host
        self._channel: Channel | None = Channel(end, most, self.look)
        self._waited: float | None = None
        self._looked = 0.0

    def __enter__(self) -> Child:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.end()
        shutil.rmtree(self.folder, ignore_errors=True)

    def send(self, message: bytes, timeout: float) -> None:
        """Send a message; if the child does not accept it, the next `receive` raises."""
        with suppress(ChannelError):
            if self._channel:
                self._channel.send(message, time.monotonic() + timeout)

    def poll(self, timeout: float) -> bytes | None:
        """Return the next message; None if none comes in this time, in s.

        Raises:
            EndedError: The child has ended, or was ended because it used too much.
            MachineError: The machine ended it, not its script.
        """
        self._waited = None
        message = ''
        try:
            if self._channel:
                if time.monotonic() > self._looked + LOOK_S:
                    self.look()
                deadline = time.monotonic() + timeout
                if not self.has_begun:
                    self._channel.receive(deadline)
                    self.has_begun = True
                return self._channel.receive(deadline)
        except LateError:
            return None
        except ChannelError as error:
            message = str(error)
        status = self.end(END if message else WAIT)
        if self._host.has_failed(self):
            raise MachineError
        places = last_places(self.folder)
        raise EndedError(message or _death(status), status, places, was_ended=bool(message))

    def receive(self, timeout: float, late: str, scripts: Collection[Path]) -> bytes:
        """Return the next message of the child, which is ended if it is late.

        Time during which other processes had the cores does not count (Linux).

        Args:
            timeout: How long it may take, in s.
            late: The message if it takes longer.
            scripts: As for `places`.

        Raises:
            EndedError, MachineError: As for `poll`.
        """
        answer = self.poll(timeout)
        if answer is not None:
            return answer
        if self._host.has_failed(self):
            raise MachineError
        places = self.places(scripts)
        raise EndedError(late, self.end(), places)

    def places(self, scripts: Collection[Path]) -> list[tuple[Path, int]]:
        """Return files and lines of the child's current or last calls, the innermost first.

        Args:
            scripts: Folders of the scripts; waits for a place in one of them.
        """
        before = places_size(self.folder)
        if not before or not self._channel or not self._host.ask_place(self.process):
            return last_places(self.folder)
        deadline = time.monotonic() + _PLACE_S
        while time.monotonic() < deadline:  # it comes line by line
            if script_of(found := last_places(self.folder, before), scripts):
                return found
            time.sleep(0.01)
        return last_places(self.folder)

    def end(self, order: bytes = END) -> int:
        """End the child and all its processes; return its exit status, 0 if it had ended.

        Args:
            order: END, or WAIT to let it end by itself first.
        """
        if self._channel is None:
            return 0
        self._channel.close()
        self._channel = None
        return self._host.end_child(self, order)

    def look(self) -> float:
        """Return how long other processes have kept the child from running, in s.

        Raises:
            ChannelError: It has ended, while a process that it started goes on; or it was
                stopped; or all children together use too much.
        """
        self._looked = time.monotonic()
        self._host.check_amounts()
        state = _state(self.process)
        if state == 'Z' and not (self._channel and self._channel.has_more()):
            raise ChannelError
        if state == 'T' and self._host.is_isolated:
            raise ChannelError('the script stopped its process')
        _, now = times_s(self.process)
        if self._waited is None:
            self._waited = now
        return min(now - self._waited, _MOST_WAITED_S)

    def unlinked_size(self) -> int:
        """Return the size of its open files that are deleted, in bytes (Linux)."""
        size = 0
        with suppress(OSError):
            for file in Path(f'/proc/{self.process}/fd').iterdir():
                with suppress(OSError):
                    status = file.stat()
                    size += 0 if status.st_nlink else 512 * status.st_blocks
        return size


def script_of(
    places: Collection[tuple[Path, int]], folders: Collection[Path]
) -> tuple[Path, int] | None:
    """Return the first of some places, file and line, in one of these folders."""
    return next(((file, line) for file, line in places if file.parent in folders), None)


def times_s(process: int) -> tuple[float, float]:
    """Return how long a process's first thread has run and waited for a core, in s (Linux)."""
    try:
        ran, waited, _ = Path(f'/proc/{process}/schedstat').read_text().split()
    except (OSError, ValueError):
        return 0.0, 0.0
    return int(ran) / 1e9, int(waited) / 1e9


def _state(process: int) -> str:
    """Return the state of a process, such as Z if only its number is left (Linux)."""
    try:
        return Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()[0]
    except (OSError, IndexError):
        return ''


def _death(status: int) -> str:
    if status == -getattr(signal, 'SIGXCPU', 0):
        return 'the script took too much processor time'
    if status < 0:
        return f'the process of the script was killed by {signal.Signals(-status).name}'
    return f'the script ended its process with exit status {status}'
