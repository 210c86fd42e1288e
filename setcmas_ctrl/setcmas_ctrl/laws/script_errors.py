"""Errors of scripts: messages with file and line, reported once per error and robot."""

from __future__ import annotations

import linecache
import re
import signal
import traceback
import types
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_imports import robot_of_frame
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.script_calls import Function, ScriptFailure


class StopCall(BaseException):
    """Raised in a running call by the signal that ends the process."""


def scripts_own(_: KeyboardInterrupt) -> bool:
    """Return whether a script raised a KeyboardInterrupt itself; Ctrl-C is handled elsewhere."""
    return signal.getsignal(signal.SIGINT) is not signal.default_int_handler


_LONGEST_TEXT = 300


def quoted_line(path: Path | str, line: int | None, indented: bool = False) -> str:
    """Return a line break and a quotation of a script's line; '' if the line does not exist."""
    source = linecache.getline(str(path), line).rstrip() if line else ''
    source = source if indented else source.strip()
    return f'\n    {line} | {source}' if source else ''


def script_place(error: BaseException, path: Path) -> tuple[Path, int | None]:
    """Return the innermost file (script or helper) and line of an error; else script and None."""
    places = places_in(traceback.walk_tb(error.__traceback__), path)
    return places[-1] if places else (path, None)


def places_in(
    frames: Iterable[tuple[types.FrameType, int]], path: Path
) -> list[tuple[Path, int | None]]:
    """Return files and lines of the frames that run the script or a helper module."""
    return [
        (Path(frame.f_code.co_filename), line)
        for frame, line in frames
        if frame.f_code.co_filename == str(path)
        # Code that a script compiles from strings has no file.
        or (robot_of_frame(frame) is not None and not frame.f_code.co_filename.startswith('<'))
    ]


def describe_failure(error: BaseException, path: Path) -> str:
    """Return a message on an error of a script: script, line, type, and the line quoted."""
    try:
        return _described(error, path)
    except StopCall:
        raise
    except BaseException:  # a script's own exception class may do anything
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


_ADVICE: tuple[tuple[type[Exception], str, str], ...] = (
    (EOFError, '', 'scripts have no input: input() and sys.stdin have nothing to read'),
    (ImportError, 'relative import', 'write `from helper import ...` without the dot'),
    (
        IndexError,
        r'index (\d+) .* axis 1 with size \1$',
        'robots are numbered from 1, columns from 0: robot i has column i - 1. With the column '
        'after that, the other robots read that of the next robot, without an error',
    ),
    (
        IndexError,
        'index',
        'indices begin at 0, robots at 1, and the last index is the length - 1; to begin again '
        'after the last, take (i + 1) % length',
    ),
    (ValueError, r'unpack \(expected 2', 'a column of poses has three numbers: x, y, theta'),
    (ValueError, r'shapes .*\(3,', 'poses has three rows, x, y, theta; positions are poses[:2]'),
)
"""Errors with a pattern of their messages, and what students then do."""


def _advice(error: BaseException) -> str:
    """Return what to do about an error after '; '; '' if unknown."""
    text = safe_text(str, error)
    if isinstance(error, UnboundLocalError) and (found := re.search(r"'(\w+)'", text)):
        *_, (frame, _) = traceback.walk_tb(error.__traceback__)
        if found[1] in frame.f_globals:
            return f'; a function that changes {found[1]} must begin with `global {found[1]}`'
        return f'; {found[1]} gets no value on this path through the function'
    for kind, pattern, advice in _ADVICE:
        if isinstance(error, kind) and (found := re.search(pattern, text)):
            return f'; {found.expand(advice)}'
    return ''


def described_place(file: Path, line: int | None, path: Path) -> str:
    """Return file and line as text, with the script's name for a helper module."""
    place = f'{file.name}, line {line}' if line else file.name
    return place if file == path else f'{place} (imported by {path.name})'


def summarise(error: BaseException) -> str:
    """Return type and message of an error on one line of limited length."""
    text = ' '.join(safe_text(str, error).split())
    text = text if len(text) <= _LONGEST_TEXT else f'{text[:_LONGEST_TEXT]}...'
    if isinstance(error, SystemExit):
        text = f'the script called exit({text})'
    return f'{type(error).__name__}: {text}' if text else type(error).__name__


def short_repr(value: Any) -> str:
    """Return the repr of a script's value on one line of at most 60 characters."""
    text = ' '.join(safe_text(repr, value).split())
    return text if len(text) <= 60 else f'{text[:57]}...'


def safe_text(describe: Callable[[Any], str], value: Any) -> str:
    """Return str or repr of a script's value; this call of the script's code may fail.

    Escapes what terminals cannot show: surrogates and control characters.
    """
    try:
        text = str.encode(describe(value), 'utf-8', 'backslashreplace').decode()
    except StopCall:
        raise
    except BaseException:
        return f'a {type(value).__name__}'
    return ''.join(
        letter if letter.isprintable() or letter.isspace() else ascii(letter)[1:-1]
        for letter in text
    )


@dataclass(eq=False)
class ControlError(Exception):
    """A call of a script failed.

    Attributes:
        key: The same for errors that a student would call the same.
        consequence: What happens to the robot, after its name; '' for the usual consequence.
        place: File and line of the error, if known.
    """

    message: str
    key: object
    consequence: str = ''
    place: tuple[Path, int | None] | None = None

    def __str__(self) -> str:
        return self.message


def failure_of(error: BaseException, path: Path) -> ControlError:
    """Return the ControlError for an exception from a function of a script."""
    place = script_place(error, path)
    return ControlError(describe_failure(error, path), (type(error).__name__, *place), place=place)


STOPPED = 'gets zero velocity; the other robots continue'
"""What happens to a robot whose control law fails."""

MOST_FAILURES = 500
"""Largest number of failures to keep; a law may fail at every other call."""


class ErrorReports:
    """Turns errors of a fleet's scripts into messages without repetition.

    Attributes:
        failures: Periods of failed calls, the first ones, sorted by time.
    """

    def __init__(
        self,
        warn: Callable[[str], None],
        consequence: str = STOPPED,
        on_new: Callable[[int, str], None] = lambda *_: None,
        function: Function = Function.CONTROL,
    ) -> None:
        """Report errors of a function of scripts by `warn`, with what follows for the robot.

        `on_new` is called with robot and message for each error that is new to the robot.
        """
        self.failures: list[ScriptFailure] = []
        self._function = function
        self._open: dict[int, tuple[int, object]] = {}  # by robot: its current failure and the key
        self._warn = warn
        self._on_new = on_new
        self._consequence = consequence
        self._reported: set[tuple[int, object]] = set()
        self._failing: Counter[int] = Counter()
        self._first: dict[object, int] = {}  # first robot with each key

    def failed(self, robot: int, t: float, error: ControlError) -> None:
        """Record a failed call of a robot's script at time t (s)."""
        self._keep(robot, t, error)
        self._failing[robot] += 1
        if (robot, error.key) not in self._reported:
            self._reported.add((robot, error.key))
            self._on_new(robot, str(error))
            name = robot_name(robot)
            first = self._first.setdefault(error.key, robot)
            if first == robot:
                consequence = error.consequence or self._consequence
                self._warn(f'{name} at t = {t:.1f} s: {error}\n    {name} {consequence}')
            else:
                self._warn(f'{name} at t = {t:.1f} s: the same error as {robot_name(first)}')

    def succeeded(self, robot: int, t: float) -> None:
        """Record a successful call of a robot's script at time t (s)."""
        if robot in self._failing:
            self._close(robot, t)
            count = self._failing.pop(robot)
            calls = 'call' if count == 1 else 'calls'
            self._warn(f'{robot_name(robot)} at t = {t:.1f} s: works again after {count} {calls}')

    def _keep(self, robot: int, t: float, error: ControlError) -> None:
        if robot in self._open and self._open[robot][1] == error.key:
            return  # the same error; its message may have other numbers
        self._close(robot, t)
        if len(self.failures) < MOST_FAILURES:
            file, line = error.place or (None, None)
            script = file.name if file else ''
            self._open[robot] = len(self.failures), error.key
            self.failures.append(
                ScriptFailure(round(t, 3), robot, self._function, script, line, str(error))
            )

    def _close(self, robot: int, t: float) -> None:
        if robot in self._open:
            number, _ = self._open.pop(robot)
            self.failures[number] = replace(self.failures[number], until=round(t, 3))

    @property
    def failed_robots(self) -> list[int]:
        """Robots whose script has failed at some time, sorted."""
        return sorted({robot for robot, _ in self._reported})
