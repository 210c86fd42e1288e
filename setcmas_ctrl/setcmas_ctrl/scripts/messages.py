"""Messages about a failed control script: where, what, and what to do."""

from __future__ import annotations

import linecache
import traceback
import types
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.scripts.imports import robot_of_frame
from setcmas_ctrl.scripts.stop_call import AbandonCall, StopCall
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import robot_name

_LONGEST_TEXT = 300


def quoted_line(path: Path | str, line: int | None, indented: bool = False) -> str:
    """Return a new line that quotes a line of a script; empty where there is none."""
    source = linecache.getline(str(path), line).rstrip() if line else ''
    source = source if indented else source.strip()
    return f'\n    {line} | {source}' if source else ''


def script_place(error: BaseException, path: Path) -> tuple[Path, int | None]:
    """Return where in the student's code an error arose.

    Returns:
        The innermost file, the script or a helper module of it, that the error passed through,
        and the line there; the script and None if it passed through neither.
    """
    places = places_in(traceback.walk_tb(error.__traceback__), path)
    return places[-1] if places else (path, None)


def places_in(
    frames: Iterable[tuple[types.FrameType, int]], path: Path
) -> list[tuple[Path, int | None]]:
    """Return files and lines of those frames that run the script or a helper module of it."""
    return [
        (Path(frame.f_code.co_filename), line)
        for frame, line in frames
        if frame.f_code.co_filename == str(path)
        # Code that a script makes of texts has no file.
        or (robot_of_frame(frame) is not None and not frame.f_code.co_filename.startswith('<'))
    ]


def describe_failure(error: BaseException, path: Path) -> str:
    """Return a message with script, line, the kind of error, and the student's own line.

    Args:
        error: What compiling, loading or calling the script raised.
        path: The script.
    """
    try:
        return _described(error, path)
    except (StopCall, AbandonCall):
        raise
    except BaseException:  # an exception of the script's own may hold anything
        return f'{path.name}: {type(error).__name__}'


def _described(error: BaseException, path: Path) -> str:
    if isinstance(error, SyntaxError):
        file = Path(error.filename) if error.filename else path
        what = f'{type(error).__name__}: {error.msg}'
        quoted = quoted_line(file, error.lineno, indented=True)
        return f'{described_place(file, error.lineno, path)}: {what}{quoted}'
    file, line = script_place(error, path)
    what = f'{summarise(error)}{_advice(error)}'
    return f'{described_place(file, line, path)}: {what}{quoted_line(file, line)}'


def _advice(error: BaseException) -> str:
    """Return what to do about an error that comes of how scripts are run; empty for others."""
    if isinstance(error, EOFError):
        return '; a script cannot be asked anything: input() and sys.stdin have nothing to read'
    if isinstance(error, ImportError) and 'relative import' in str(error):
        return '; write `from helper import ...` without the dot'
    return ''


def described_place(file: Path, line: int | None, path: Path) -> str:
    """Return file and line in words, with the script if the file is a helper module."""
    place = f'{file.name}, line {line}' if line else file.name
    return place if file == path else f'{place} (imported by {path.name})'


def unheard_robots(robot: int, poses: Floats) -> str:
    """Return a new line that names the robots whose poses a robot does not know, or nothing.

    Args:
        robot: Number of the robot whose script was called.
        poses: What the script was given, shape (3, N), NaN for robots that are not heard.
    """
    unheard = (np.flatnonzero(np.isnan(poses).any(axis=0)) + 1).tolist()
    if not unheard:
        return ''
    robots = robots_in_words(unheard)
    return (
        f'\n    {robot_name(robot)} does not hear {robots}: poses is NaN there; '
        'network.neighbours() tells whom it hears (from setcmas_ctrl import network)'
    )


def summarise(error: BaseException) -> str:
    """Return the kind and the text of an error on one line, which is not endless."""
    text = ' '.join(safe_text(str, error).split())
    text = text if len(text) <= _LONGEST_TEXT else f'{text[:_LONGEST_TEXT]}...'
    if isinstance(error, SystemExit):
        text = f'the script ended itself with exit({text})'
    return f'{type(error).__name__}: {text}' if text else type(error).__name__


def safe_text(describe: Callable[[Any], str], value: Any) -> str:
    """Return str or repr of a value of a script, which may fail as anything in a script may.

    What a terminal cannot show (surrogates, control characters) is escaped.
    """
    try:
        text = str.encode(describe(value), 'utf-8', 'backslashreplace').decode()
    except (StopCall, AbandonCall):
        raise
    except BaseException:
        return f'a {type(value).__name__}'
    return ''.join(letter if _is_shown(letter) else ascii(letter)[1:-1] for letter in text)


def _is_shown(letter: str) -> bool:
    return letter.isprintable() or letter.isspace()
