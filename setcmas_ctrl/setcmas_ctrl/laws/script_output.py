"""Output of scripts: puts the robot's name before each line; shows the first lines only."""

from __future__ import annotations

import contextlib
import sys
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from typing import IO, Any, cast

from setcmas_ctrl.laws.script_imports import calling_robot
from setcmas_simu.fleet.topics import robot_name


class ScriptOutput:
    """Replaces sys.stdout or sys.stderr; output that comes from no script passes unchanged."""

    def __init__(self, stream: IO[str]) -> None:
        # A law may run others, whose output has its names already.
        self._stream: IO[str] = stream._stream if isinstance(stream, ScriptOutput) else stream
        self._begun: defaultdict[int, str] = defaultdict(str)
        """Unfinished lines by robot."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text; put the robot's name before lines of scripts."""
        robot = calling_robot()
        if robot is None:
            return self._stream.write(text)
        lines, newline, self._begun[robot] = (self._begun[robot] + text).rpartition('\n')
        if newline:
            self._write_lines(robot, lines)
        return len(text)

    def writelines(self, texts: Iterable[str]) -> None:
        """Write several texts."""
        for text in texts:
            self.write(text)

    def close(self) -> None:
        """Stay open: other scripts write to this stream too."""

    def end_lines(self) -> None:
        """Write unfinished lines."""
        for robot in list(self._begun):
            if text := self._begun.pop(robot):
                self._write_lines(robot, text)

    def _write_lines(self, robot: int, lines: str) -> None:
        prefix = f'{robot_name(robot)}: '
        self._stream.write(''.join(f'{prefix}{line}\n' for line in lines.split('\n')))
        self._stream.flush()


_ended: deque[ScriptOutput] = deque(maxlen=100)
"""Keeps streams for threads inside print(), which does not hold sys.stdout (CPython 130163)."""


@contextlib.contextmanager
def named_output() -> Iterator[None]:
    """Within this context, put the robot's name before each line that a script prints."""
    stdout, stderr = ScriptOutput(sys.stdout), ScriptOutput(sys.stderr)
    with (
        contextlib.redirect_stdout(cast(IO[str], stdout)),
        contextlib.redirect_stderr(cast(IO[str], stderr)),
    ):
        try:
            yield
        finally:
            stdout.end_lines()
            stderr.end_lines()
            _ended.extend((stdout, stderr))


_MOST_SHOWN = 50


class LimitedOutput:
    """Shows the first lines, and counts the others."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._nb_lines = 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text, up to the last line to show."""
        for part in text.splitlines(keepends=True):
            if self._nb_lines < _MOST_SHOWN:
                self._stream.write(part)
            self._nb_lines += part.endswith('\n')
        return len(text)

    def end(self) -> None:
        """Write how many lines are left out."""
        if self._nb_lines > _MOST_SHOWN:
            self._stream.write(f'... {self._nb_lines - _MOST_SHOWN:,} more lines\n')


@contextlib.contextmanager
def limited_output() -> Iterator[None]:
    """Show the first lines on sys.stdout only, inside."""
    limited = LimitedOutput(sys.stdout)
    with contextlib.redirect_stdout(cast(IO[str], limited)):
        try:
            yield
        finally:
            limited.end()
