"""Messages with fields as lines of JSON, for pipes between processes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, TypeVar

import msgspec


class Message(msgspec.Struct, frozen=True, tag=True):
    """Base class of messages between processes; each kind is a subclass with its fields."""


AnyMessage = TypeVar('AnyMessage', bound=Message)


def encode(message: Message) -> bytes:
    """Return a message as one line for `LineDecoder`."""
    # Starts with a line break, in case the previous line was cut off.
    return b'\n' + msgspec.json.encode(message) + b'\n'


class LineDecoder(Generic[AnyMessage]):
    """Turns the bytes of a pipe into messages."""

    def __init__(self, kinds: Any) -> None:
        """Decode messages of one class, or of a union of classes."""
        self._decoder: msgspec.json.Decoder[AnyMessage] = msgspec.json.Decoder(kinds)
        self._rest = b''

    def feed(self, data: bytes) -> Iterator[AnyMessage]:
        """Yield the messages that these bytes complete.

        Skips lines that are no messages: a script can find the pipe and write to it.
        """
        *lines, self._rest = (self._rest + data).split(b'\n')
        for line in lines:
            try:
                yield self._decoder.decode(line)
            except (msgspec.DecodeError, UnicodeDecodeError):
                continue
