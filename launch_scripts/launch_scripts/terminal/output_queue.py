"""Queue of output that never blocks the launcher: a thread writes it, a full queue drops it.

A paused terminal or a pager that does not read must not stop the robots' processes, whose output
the launcher has to take, nor delay a stop.
"""

from __future__ import annotations

import io
import os
import queue
import threading
from typing import IO

_CAPACITY = 2000  # pieces of text
_LAST_WORDS_S = 1.0


class OutputQueue:
    """Writes texts to file descriptors, in order, from a thread of its own.

    Attributes:
        broken: Whether a reader has gone away (closed terminal or pipe).
    """

    def __init__(self) -> None:
        """Start the thread."""
        self.broken = False
        self._dropped = 0
        self._texts: queue.Queue[tuple[int, str] | None] = queue.Queue(_CAPACITY)
        self._thread = threading.Thread(target=self._write_all, name='output', daemon=True)
        self._thread.start()

    def put(self, descriptor: int, text: str) -> None:
        """Write a text soon; drop it if too much is waiting already."""
        try:
            self._texts.put_nowait((descriptor, text))
        except queue.Full:
            self._dropped += 1

    def close(self) -> None:
        """Wait, but not for long, until everything is written."""
        try:
            self._texts.put(None, timeout=_LAST_WORDS_S)
        except queue.Full:
            return
        self._thread.join(_LAST_WORDS_S)

    def _write_all(self) -> None:
        while (item := self._texts.get()) is not None:
            descriptor, text = item
            if self._dropped:
                text = f'({self._dropped} pieces of output were dropped)\n{text}'
                self._dropped = 0
            try:
                data = memoryview(text.encode(errors='replace'))
                while data:
                    data = data[os.write(descriptor, data) :]
            except OSError:
                self.broken = True


class QueuedStream(io.TextIOBase):
    """A text stream that writes through an OutputQueue."""

    encoding = 'utf-8'  # that of `OutputQueue`: tqdm draws its bar accordingly

    def __init__(self, output: OutputQueue, stream: IO[str]) -> None:
        """Stand for a stream that has a file descriptor."""
        self._output = output
        self._descriptor = stream.fileno()

    def write(self, text: str) -> int:
        """Write a text soon."""
        self._output.put(self._descriptor, text)
        return len(text)

    def fileno(self) -> int:
        """Return the descriptor of the stream that this one stands for."""
        return self._descriptor

    def isatty(self) -> bool:
        """Return whether that stream is a terminal."""
        return os.isatty(self._descriptor)
