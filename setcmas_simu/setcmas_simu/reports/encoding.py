"""Messages with fields as lines of JSON, for pipes between processes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, TypeVar

import msgspec


class Message(msgspec.Struct, frozen=True, tag=True):
    """A message between processes; a class with fields for each kind."""


AnyMessage = TypeVar('AnyMessage', bound=Message)


def encode(message: Message) -> bytes:
    """Return a message as a line, which `LineDecoder` understands."""
    # A line of its own even where the one before was cut off.
    return b'\n' + msgspec.json.encode(message) + b'\n'


class LineDecoder(Generic[AnyMessage]):
    """Takes the bytes of a pipe as they come, and hands out messages."""

    def __init__(self, kinds: Any) -> None:
        """Understand messages of one class, or of a union of classes."""
        self._decoder: msgspec.json.Decoder[AnyMessage] = msgspec.json.Decoder(kinds)
        self._rest = b''

    def feed(self, data: bytes) -> Iterator[AnyMessage]:
        """Yield the messages that are complete with these bytes.

        What is no message is left out: a script can find the pipe and write to it.
        """
        *lines, self._rest = (self._rest + data).split(b'\n')
        for line in lines:
            try:
                yield self._decoder.decode(line)
            except (msgspec.DecodeError, UnicodeDecodeError):
                continue
