"""Output of scripts: puts the robot's name before each line, and folds repeated lines."""

from __future__ import annotations

import contextlib
import re
import sys
from collections import Counter, defaultdict, deque
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


_SHOWN_ALIKE = 5
_MOST_SHOWN = 50
_NUMBERS = re.compile(r'[-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|\bnan\b|\binf\b)|\s+')


class FoldedOutput:
    """Shows a few of the lines that differ only in numbers, and counts the others."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._begun = ''
        self._counts: Counter[str] = Counter()
        self._shown = 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text up to its last line break."""
        *lines, self._begun = (self._begun + text).split('\n')
        for line in lines:
            kind = _NUMBERS.sub('', line)
            self._counts[kind] += 1
            if self._counts[kind] <= _SHOWN_ALIKE and self._shown < _MOST_SHOWN:
                self._shown += 1
                self._stream.write(f'{line}\n')
        return len(text)

    def end(self) -> None:
        """Write the last line, and how many lines are left out."""
        if self._begun:
            self.write('\n')
        if left_out := sum(self._counts.values()) - self._shown:
            self._stream.write(f'... {left_out:,} more lines like these\n')


@contextlib.contextmanager
def folded_output() -> Iterator[None]:
    """Fold repeated lines on sys.stdout, inside."""
    folded = FoldedOutput(sys.stdout)
    with contextlib.redirect_stdout(cast(IO[str], folded)):
        try:
            yield
        finally:
            folded.end()
