"""Reading of sqlite3 bags that were cut short or damaged: the rows before the damage."""

from __future__ import annotations

import contextlib
import sqlite3
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from rosbags.interfaces import Connection, ConnectionExtRosbag2, MessageDefinition

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.source import Entry, Extent, message_definition, one_line


class SqliteSalvage:
    """The readable rows of a .db3 file, in the order in which they were stored.

    Attributes:
        connections: Topic, type, definition and number of messages of each topic.
        extent: What could be read.
        notices: A line for each thing that was lost.
    """

    def __init__(self, path: Path) -> None:
        """Scan a file.

        Raises:
            SetcmasError: The content is not a rosbag2 database, or nothing in it is readable.
        """
        self._path = path
        self._failure = ''
        self._database = _open(path)
        try:
            topics = self._topics()
        except sqlite3.Error as error:
            self.close()
            raise SetcmasError(f"'{path}' cannot be read as a bag: {one_line(error)}") from error
        self.extent = Extent()
        counts: Counter[int] = Counter()
        for topic_id, time_ns, _ in self._rows():
            counts[topic_id] += 1
            self.extent.add(time_ns)
        self.connections = [c._replace(msgcount=counts[c.id], owner=self) for c in topics]
        self.notices = list(self._losses())

    def messages(self) -> Iterator[Entry]:
        """Yield all messages before the damage."""
        connections = {connection.id: connection for connection in self.connections}
        for topic_id, time_ns, data in self._rows():
            if topic_id in connections:
                yield connections[topic_id], time_ns, data

    def close(self) -> None:
        """Release the file."""
        self._database.close()

    def _topics(self) -> list[Connection]:
        rows = self._database.execute('SELECT id, name, type, serialization_format FROM topics')
        definitions = self._definitions()
        none = message_definition('', '')
        return [
            Connection(
                topic_id,
                name,
                msgtype,
                definitions.get(msgtype, none),
                digest='',
                msgcount=0,
                ext=ConnectionExtRosbag2(serialisation, []),
                owner=None,
            )
            for topic_id, name, msgtype, serialisation in rows
        ]

    def _rows(self) -> Iterator[tuple[int, int, bytes]]:
        # By id, which follows the table itself: the index on the time may be what is damaged.
        try:
            yield from self._database.execute(
                'SELECT topic_id, timestamp, data FROM messages '
                "WHERE typeof(timestamp) = 'integer' AND typeof(data) = 'blob' ORDER BY id"
            )
        except sqlite3.Error as error:
            self._failure = str(error)

    def _definitions(self) -> dict[str, MessageDefinition]:
        # Bags from before Iron have no such table.
        with contextlib.suppress(sqlite3.Error):
            return {
                msgtype: message_definition(encoding, text)
                for msgtype, encoding, text in self._database.execute(
                    'SELECT topic_type, encoding, encoded_message_definition '
                    'FROM message_definitions'
                )
            }
        return {}

    def _losses(self) -> Iterator[str]:
        if self._failure:
            yield (
                f"'{self._path}' is damaged ({self._failure}): {self.extent} were read, "
                'the rest is lost'
            )


def _open(path: Path) -> sqlite3.Connection:
    # Without a write-ahead log, the file is read as it is, even on a read-only disk.
    mode = 'mode=ro' if Path(f'{path}-wal').exists() else 'mode=ro&immutable=1'
    database = sqlite3.connect(f'{path.resolve().as_uri()}?{mode}', uri=True)
    # Lets SQLite open a file that is shorter than its header says.
    database.execute('PRAGMA writable_schema=ON')
    return database
