"""What a student is told when a control script fails: where, what, and what is expected."""

from __future__ import annotations

import linecache
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any


def quoted_line(path: Path | str, line: int | None, indented: bool = False) -> str:
    """Return a new line that quotes a line of a script; empty where there is none."""
    source = linecache.getline(str(path), line).rstrip() if line else ''
    source = source if indented else source.strip()
    return f'\n    {line} | {source}' if source else ''


def script_line(error: BaseException, path: Path) -> int | None:
    """Return the innermost line of the script that an error passed through; None if none."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == str(path)]
    return lines[-1] if lines else None


def describe_failure(error: BaseException, path: Path) -> str:
    """Return a message with script, line, the kind of error, and the student's own line.

    Args:
        error: What compiling, loading or calling the script raised.
        path: The script.
    """
    if isinstance(error, SyntaxError):
        file = Path(error.filename) if error.filename else path
        what = f'{type(error).__name__}: {error.msg}'
        return (
            f'{_where(file, error.lineno)}: {what}{quoted_line(file, error.lineno, indented=True)}'
        )
    line = script_line(error, path)
    return f'{_where(path, line)}: {summarise(error)}{quoted_line(path, line)}'


def summarise(error: BaseException) -> str:
    """Return the kind and the text of an error on one line."""
    text = ' '.join(safe_text(str, error).split())
    if isinstance(error, SystemExit):
        text = f'the script ended itself with exit({text})'
    return f'{type(error).__name__}: {text}' if text else type(error).__name__


def safe_text(describe: Callable[[Any], str], value: Any) -> str:
    """Return str or repr of a value of a script, which may fail as anything in a script may."""
    try:
        return describe(value)
    except Exception:
        return f'a {type(value).__name__}'


def _where(path: Path, line: int | None) -> str:
    return f'{path.name}, line {line}' if line else path.name
