"""Reader of the console's messages on the standard input of the pause process."""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator

from setcmas_expe.pause.console_protocol import OLD_AFTER_S, SILENT_AFTER_S, Wish, Word
from setcmas_expe.safety.stalls import time_since_boot
from setcmas_simu.reports.reports import LineDecoder

_CATCHES_UP_S = 0.2
_NEVER_LATE = (Word.START, Word.RELEASE)


class ConsoleReader:
    """Takes wishes in a thread of its own; hands them out without waiting.

    A key that comes after a silence, or together with others that were held up, was pressed some
    time ago, as was one that tells an old time: what has happened since, nobody knew who pressed
    it, and it must not start anything.
    """

    def __init__(self, on_end: Callable[[], None]) -> None:
        """Start to read; the thread calls `on_end` when the terminal's process is gone."""
        self._wishes: queue.SimpleQueue[Wish] = queue.SimpleQueue()
        self._heard = time.monotonic()
        self._told = False
        self._late: queue.SimpleQueue[Word] = queue.SimpleQueue()
        self._on_end = on_end
        threading.Thread(target=self._read, name='console', daemon=True).start()

    def wishes(self) -> Iterator[Wish]:
        """Yield what has come in since the last call."""
        while not self._wishes.empty():
            yield self._wishes.get()

    def late(self) -> Iterator[Word]:
        """Yield the words that came too late to count, since the last call."""
        while not self._late.empty():
            yield self._late.get()

    @property
    def stuck(self) -> bool:
        """Whether the terminal was silent when that was looked at last."""
        return self._told

    def silent(self, now: float) -> bool:
        """Return, once, whether nothing has come for so long that the terminal must be stuck."""
        silent = now - self._heard > SILENT_AFTER_S
        first, self._told = silent and not self._told, silent
        return first

    def _read(self) -> None:
        late_until = 0.0
        decoder: LineDecoder[Wish] = LineDecoder(Wish)
        while data := os.read(sys.stdin.fileno(), 4096):
            for wish in decoder.feed(data):
                now = time.monotonic()
                if now - self._heard > SILENT_AFTER_S:
                    late_until = now + _CATCHES_UP_S
                self._heard = now
                old = now < late_until or time_since_boot() - wish.made > OLD_AFTER_S
                if old and wish.word in _NEVER_LATE:
                    self._late.put(wish.word)
                else:
                    self._wishes.put(wish)
        self._on_end()
