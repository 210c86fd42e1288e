"""Source of messages: one file of a bag, and the reader of files in good order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader

Entry = tuple[Connection, int, bytes]
"""Connection, receive time in ns, and the serialised message."""

_LONGEST_REASON = 120


def one_line(error: Exception) -> str:
    """Return the message of a library's error in one line that fits a terminal."""
    text = ' '.join(str(error).split()) or 'inconsistent content'
    return text if len(text) <= _LONGEST_REASON else f'{text[:_LONGEST_REASON]} ...'


@dataclass
class Extent:
    """How much there is: number of messages, times of the first and the last in ns."""

    count: int = 0
    start_ns: int = 0
    end_ns: int = 0

    def add(self, time_ns: int) -> None:
        """Count a message."""
        self.start_ns = min(self.start_ns, time_ns) if self.count else time_ns
        self.end_ns = max(self.end_ns, time_ns) if self.count else time_ns
        self.count += 1

    def __str__(self) -> str:
        """Return text such as '3,412 messages up to 12.3 s'."""
        if not self.count:
            return 'no messages'
        return f'{self.count:,} messages up to {(self.end_ns - self.start_ns) / 1e9:.1f} s'


class BagSource(Protocol):
    """One file of a bag.

    Attributes:
        connections: Topic, type, definition and number of messages of each connection.
        extent: What the file holds, as far as it can be read.
        notices: A line for each thing that was lost; complete once `messages` has ended.
    """

    connections: list[Connection]
    extent: Extent
    notices: list[str]

    def messages(self) -> Iterator[Entry]:
        """Yield all messages."""

    def close(self) -> None:
        """Release the file."""


class IndexedSource:
    """A file, or a folder, that rosbags opens."""

    def __init__(self, path: Path, reader: Ros1Reader | Ros2Reader) -> None:
        """Open a file.

        Args:
            path: The file, for messages.
            reader: A reader of it that is not open yet; it raises what it likes if it cannot.
        """
        self._path = path
        self._reader = reader
        reader.open()
        self.connections: list[Connection] = list(reader.connections)
        # Readers put the end a nanosecond after the last message.
        self.extent = Extent(reader.message_count, reader.start_time, reader.end_time - 1)
        self.notices: list[str] = []

    def messages(self) -> Iterator[Entry]:
        """Yield all messages up to the first damage, which gets a notice."""
        read = Extent()
        reason = 'some are missing'
        try:
            for entry in self._reader.messages():
                read.add(entry[1])
                yield entry
        except Exception as error:  # a damaged file makes any of several libraries fail
            reason = one_line(error)
        if read.count < self.extent.count:
            self.notices.append(
                f"'{self._path}' is damaged ({reason}): {read} of {self.extent.count:,} were read"
            )

    def close(self) -> None:
        """Release the file."""
        self._reader.close()
