"""Output above a progress bar, whichever stream it goes to."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import IO, Any, cast

from tqdm import tqdm


class _ProgressOutput:
    def __init__(self, stream: IO[str], bar_stream: IO[str]) -> None:
        self._stream = stream
        self._bar_stream = bar_stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        with tqdm.external_write_mode(file=self._bar_stream):
            return self._stream.write(text)


@contextlib.contextmanager
def progress_output() -> Iterator[None]:
    """Take a bar on stderr away while something else is written, which must be whole lines."""
    bar = sys.stderr
    with (
        contextlib.redirect_stdout(cast(IO[str], _ProgressOutput(sys.stdout, bar))),
        contextlib.redirect_stderr(cast(IO[str], _ProgressOutput(sys.stderr, bar))),
    ):
        yield
