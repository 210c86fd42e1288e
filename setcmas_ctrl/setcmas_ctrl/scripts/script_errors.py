"""Errors of control scripts: script, robot, time, the line at fault, and what to do."""

from __future__ import annotations

import linecache
import signal
import traceback
import types
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from setcmas_ctrl.scripts.imports import robot_of_frame
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.reports import Function, ScriptFailure


class StopCall(BaseException):
    """Raised in a call of a script by the signal that ends the process."""


class AbandonCall(BaseException):
    """Raised in a stuck call of a script when a new version of the script is there."""


def scripts_own(_: KeyboardInterrupt) -> bool:
    """Return whether a KeyboardInterrupt is the script's own, as Ctrl-C is handled otherwise."""
    return signal.getsignal(signal.SIGINT) is not signal.default_int_handler


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


class ControlError(Exception):
    """A call of `control` failed.

    Attributes:
        key: The same for errors that a student would call the same.
        consequence: What happens to the robot, after its name; empty if it is as usual.
        place: File and line that failed, if they are known.
    """

    def __init__(
        self,
        message: str,
        key: object,
        consequence: str = '',
        place: tuple[Path, int | None] | None = None,
    ) -> None:
        """Store the message, what identifies the error, what comes of it, and where it was."""
        super().__init__(message)
        self.key = key
        self.consequence = consequence
        self.place = place


def failure_of(error: BaseException, path: Path) -> ControlError:
    """Return what to tell of an error that a function of a script raised."""
    place = script_place(error, path)
    return ControlError(describe_failure(error, path), (type(error).__name__, *place), place=place)


STANDS = 'is commanded zero; this stops no other robot'
"""What happens to a robot whose control law fails."""

MOST_FAILURES = 500
"""So many are kept with their times; a law may fail and work again at each other call."""


class ErrorReports:
    """Turns the errors of a fleet's scripts into messages that are not repeated.

    Attributes:
        failures: When which script failed for whom, the first ones, sorted by time.
    """

    def __init__(
        self,
        warn: Callable[[str], None],
        consequence: str = STANDS,
        on_new: Callable[[int, str], None] = lambda *_: None,
        function: Function = Function.CONTROL,
    ) -> None:
        """Report through a function that shows a message to the user.

        Args:
            warn: Shows a message to the user.
            consequence: What happens to a robot whose script fails, after its name.
            on_new: Takes robot and text of an error that is new for the robot.
            function: What of a script is called.
        """
        self.failures: list[ScriptFailure] = []
        self._function = function
        self._open: dict[int, tuple[int, object]] = {}  # by robot, which failure goes on, its key
        self._warn = warn
        self._on_new = on_new
        self._consequence = consequence
        self._counts: Counter[tuple[int, object]] = Counter()
        self._failing: Counter[int] = Counter()
        self._first: dict[str, int] = {}  # the robot for which a text was shown

    def failed(self, robot: int, t: float, error: ControlError) -> None:
        """Note that a robot's script failed at time t (s)."""
        self._keep(robot, t, error)
        self._failing[robot] += 1
        self._counts[robot, error.key] += 1
        if self._counts[robot, error.key] == 1:
            self._on_new(robot, str(error))
            name = robot_name(robot)
            first = self._first.setdefault(str(error), robot)
            if first == robot:
                consequence = error.consequence or self._consequence
                self._warn(f'{name} at t = {t:.1f} s: {error}\n    {name} {consequence}')
            else:
                self._warn(f'{name} at t = {t:.1f} s: the same error as {robot_name(first)}')

    def succeeded(self, robot: int, t: float) -> None:
        """Note that a robot's script did its work at time t (s)."""
        if robot in self._failing:
            self._close(robot, t)
            count = self._failing.pop(robot)
            calls = 'call' if count == 1 else 'calls'
            self._warn(f'{robot_name(robot)} at t = {t:.1f} s: works again after {count} {calls}')

    def _keep(self, robot: int, t: float, error: ControlError) -> None:
        if robot in self._open and self._open[robot][1] == error.key:
            return  # the text may hold other numbers
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
            ended = msgspec.structs.replace(self.failures[number], until=round(t, 3))
            self.failures[number] = ended

    @property
    def failed_robots(self) -> list[int]:
        """The robots whose script has failed at some time, sorted."""
        return sorted({robot for robot, _ in self._counts})

    def summary(self) -> list[str]:
        """Return a line for each error that occurred more than once to a robot."""
        robots_of: defaultdict[object, list[int]] = defaultdict(list)
        for (robot, key), count in self._counts.items():
            if count > 1:
                robots_of[key].append(robot)
        return [self._summed_up(key, robots) for key, robots in robots_of.items()]

    def _summed_up(self, key: object, robots: list[int]) -> str:
        count = sum(self._counts[robot, key] for robot in robots)
        if len(robots) == 1:
            return f'{robot_name(robots[0])}: {_name(key)} occurred {count} times'
        return f'{robots_in_words(sorted(robots))}: {_name(key)} occurred {count} times in all'


def _name(key: object) -> str:
    if isinstance(key, tuple) and key[0] != 'result':
        kind, file, line = key
        return f'{kind} in {file.name}, line {line}' if line else str(kind)
    return 'a result that is of no use'
