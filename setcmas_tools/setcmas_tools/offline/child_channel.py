"""Channel: messages between a process and one that it does not trust: sized, bounded and timed."""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Callable
from contextlib import suppress

from setcmas_simu.errors import SetcmasError

LOOK_S = 0.1
"""Time between two looks at the other side while it sends nothing."""

_SIZE = struct.Struct('<Q')
_PART = 1 << 16  # a larger one would be mapped anew for each message


class ChannelError(Exception):
    """The other side has ended, is late, or sends what it must not."""


class LateError(ChannelError):
    """The other side has not answered in time."""


class MachineError(SetcmasError):
    """The machine keeps a script from running; the script is not the cause."""

    def __init__(self) -> None:
        super().__init__(
            'this computer cannot run more processes for scripts; are memory, disk and number '
            'of processes sufficient?'
        )


class Channel:
    """One end of a connection on which messages of bytes go both ways."""

    def __init__(
        self, end: socket.socket, most: int, look: Callable[[], float] | None = None
    ) -> None:
        """Use a socket.

        Args:
            end: The socket.
            most: Size of the longest message that is accepted, in bytes.
            look: Called every `LOOK_S` while nothing comes; returns by how much later to give up,
                in s, and may raise ChannelError. None: there is no deadline.
        """
        self._end = end
        self._most = most
        self._look = look or float
        self._size: int | None = None
        self._rest = bytearray()
        end.settimeout(LOOK_S if look else None)

    def send(self, message: bytes, deadline: float) -> None:
        """Send a message.

        Args:
            message: The message.
            deadline: When to give up, on the clock of `time.monotonic`.

        Raises:
            ChannelError: The other side has ended, or does not read.
        """
        left = memoryview(_SIZE.pack(len(message)) + message)
        while left:
            try:
                left = left[self._end.send(left) :]
            except TimeoutError:
                self._wait(deadline)
            except OSError as error:
                raise ChannelError from error

    def receive(self, deadline: float) -> bytes:
        """Return the next message; after LateError, the rest of it may still be received.

        Args:
            deadline: When to give up, on the clock of `time.monotonic`.

        Raises:
            ChannelError: The other side has ended, is late, or sends a message that is too long.
        """
        if self._size is None:
            (self._size,) = _SIZE.unpack(self._read(_SIZE.size, deadline))
        if self._size > self._most:
            raise ChannelError('the script wrote on its connection with the grader')
        message = self._read(self._size, deadline)
        self._size = None
        return message

    def has_more(self) -> bool:
        """Return whether a message waits to be read, as far as the system knows."""
        with suppress(OSError, AttributeError):
            return bool(self._end.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT))
        return False

    def close(self) -> None:
        """Send and receive no more."""
        self._end.close()

    def _read(self, size: int, deadline: float) -> bytes:
        while len(self._rest) < size:
            try:
                part = self._end.recv(_PART)
            except TimeoutError:
                self._wait(deadline)
                continue
            except OSError as error:
                raise ChannelError from error
            if not part:
                raise ChannelError
            self._rest += part
            if len(self._rest) < size:
                self._wait(deadline)
        read = bytes(self._rest[:size])
        del self._rest[:size]
        return read

    def _wait(self, deadline: float) -> None:
        if time.monotonic() > deadline + self._look():
            raise LateError
