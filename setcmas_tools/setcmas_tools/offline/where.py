"""Place in a script where a process was when it was asked (SIGUSR1), died or ended, in a file."""

from __future__ import annotations

import faulthandler
import os
import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

WHERE = 'where'
"""Name of the file."""

_FRAME = re.compile(r'^  File "(?P<file>.*)", line (?P<line>\d+) in ', re.MULTILINE)


def tell_where(folder: Path) -> None:
    """Let this process write where it is into a folder when it is asked, crashes or ends."""
    file = (folder / WHERE).open('w', encoding='utf-8')
    faulthandler.enable(file, all_threads=False)
    if hasattr(signal, 'SIGUSR1'):
        faulthandler.register(signal.SIGUSR1, file, all_threads=False)
        print('can be asked', file=file, flush=True)
    os._exit = _telling(os._exit, file)
    os.kill = _telling(os.kill, file)
    signal.raise_signal = _telling(signal.raise_signal, file)


def told_places(text: str) -> list[tuple[Path, int]]:
    """Return the files and lines that a process told last, the innermost first.

    Args:
        text: What its file holds.
    """
    last = text.rpartition('(most recent')[2]
    return [(Path(found['file']), int(found['line'])) for found in _FRAME.finditer(last)]


def _telling(function: Callable[..., Any], file: IO[str]) -> Callable[..., Any]:
    def tell_and_call(*args: Any) -> Any:
        faulthandler.dump_traceback(file, all_threads=False)
        return function(*args)

    return tell_and_call
