"""Kinds of values that options take: read from a text, checked, described."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from numbers import Integral, Real
from pathlib import Path
from typing import Any, ClassVar

from setcmas_simu.errors import SetcmasError, it_must_be
from setcmas_simu.fleet.fleet import mapped, parse_robots
from setcmas_simu.fleet.topics import MAX_ROBOTS
from setcmas_simu.yaml_entries import Entry


def is_number(value: Any) -> bool:
    """Return whether a value is a real number, and no truth value."""
    return isinstance(value, Real) and not isinstance(value, bool)


@dataclass(frozen=True)
class Kind:
    """Any text.

    Attributes:
        metavar: Placeholder in help texts.
        choices: Words to offer in help texts and messages.
    """

    metavar: str | None = field(default=None, kw_only=True)
    choices: tuple[str, ...] = field(default=(), kw_only=True)

    gather: ClassVar[type] = tuple
    """Makes the value of an option with several values."""

    @property
    def must_be(self) -> str:
        """Words that follow "must be" in messages."""
        return 'a text'

    def expected(self, value: Any) -> str:
        """Return the words that follow "must be" for a refused value."""
        del value  # other kinds look at it
        return self.must_be

    def accepts(self, value: Any) -> bool:
        """Return whether a value is of this kind."""
        return isinstance(value, str)

    def value(self, given: Any) -> Any:
        """Convert a text of a command line, or a value from Python or YAML; wrong ones stay."""
        return given

    def located(self, value: Any, place: Callable[[str], str]) -> Any:
        """Replace the files that a YAML value names by their paths."""
        del place  # most values name no file
        return value

    def read(self, entry: Entry, place: Callable[[str], str]) -> Any:
        """Return the value of a YAML entry, unchecked, or raise SetcmasError if it is malformed.

        `place` returns the path of a file that a text names, and other texts unchanged.
        """
        return self.value(self.located(entry.plain(), place))

    def of(self, entry: Entry) -> Any:
        """Return the value of a YAML entry, or raise SetcmasError with file and line."""
        value = self.value(entry.plain())
        if not self.accepts(value):
            raise entry.mistake(self.expected(value), self.choices)
        return value

    def check(self, name: str, value: Any) -> None:
        """Raise SetcmasError unless a value is of this kind; `name` is its name in the message."""
        if not self.accepts(value):
            shown = str(value).removesuffix('.0') if isinstance(value, Real) else repr(value)
            expected = it_must_be(self.expected(value), value, self.choices)
            raise SetcmasError(f'{name} is {shown}{expected}')


@dataclass(frozen=True)
class Number(Kind):
    """Real numbers, above a bound or from `least` to `most`; `finite` refuses inf (no limit)."""

    above: float = -math.inf
    least: float = -math.inf
    most: float = math.inf
    unit: str = ''
    finite: bool = False

    @property
    def must_be(self) -> str:
        """The bounds, with their unit."""
        lower = f'at least {self.least:g}' if self.least > -math.inf else f'above {self.above:g}'
        if self.most < math.inf:
            at_least = self.least > -math.inf
            lower = f'from {self.least:g} to' if at_least else f'{lower} and at most'
            lower = f'{lower} {self.most:g}'
        return f'{lower} {self.unit}'.rstrip() + ' and finite' * self.finite

    def expected(self, value: Any) -> str:
        """Return the bounds; they begin with "a number" unless the value is one."""
        of = 'of ' * self.must_be.startswith('at least')
        return self.must_be if is_number(value) else f'a number {of}{self.must_be}'

    def value(self, given: Any) -> Any:
        """Return a number, or the one in a text, as a float."""
        try:
            return float(given) if isinstance(given, str) or is_number(given) else given
        except ValueError:
            return given

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a number within the bounds."""
        inside = is_number(value) and self.above < value and self.least <= value <= self.most
        return inside and not (self.finite and math.isinf(value))


MAX_RATE_HZ = 200.0
RATE = Number(above=0, most=MAX_RATE_HZ, unit='Hz')
"""Rates that a process can keep."""

LENGTH = Number(above=0, unit='m', finite=True)
DURATION = Number(above=0, unit='s', finite=True)
ACCELERATION = Number(above=0, unit='m/s^2')
"""Accelerations; inf is no limit."""


@dataclass(frozen=True)
class Whole(Kind):
    """Whole numbers from `least` to `most`; None is no limit."""

    least: int = 0
    most: int | None = None
    metavar: str | None = field(default='N', kw_only=True)

    @property
    def must_be(self) -> str:
        """The bounds."""
        upper = '' if self.most is None else f' to {self.most}'
        return f'a whole number from {self.least}{upper}'

    def value(self, given: Any) -> Any:
        """Return a number as an int, also 2.0 in a range of a study, or the one in a text."""
        is_text = isinstance(given, str) and given.removeprefix('-').isdecimal()
        return int(given) if is_text or (is_number(given) and given % 1 == 0) else given

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a whole number within the bounds."""
        is_whole = is_number(value) and isinstance(value, Integral)
        return is_whole and self.least <= value <= (math.inf if self.most is None else self.most)


NB_ROBOTS = Whole(1, MAX_ROBOTS)
"""Sizes of a fleet; memory and time grow with its square."""

SEEDS = Whole(0, 2**32 - 1)
"""Seeds that every generator takes."""


@dataclass(frozen=True)
class OneOf(Kind):
    """Words of a list."""

    choices: tuple[str, ...] = field(kw_only=False)

    @property
    def must_be(self) -> str:
        """The list."""
        *others, last = self.choices
        return f'{", ".join(others)} or {last}' if others else last

    def accepts(self, value: Any) -> bool:
        """Return whether a value is in the list."""
        return value in self.choices


@dataclass(frozen=True)
class ParsedText(Kind):
    """Texts of a form that a function reads; it raises SetcmasError for other texts."""

    read_text: Callable[[str], object]
    form: str

    @property
    def must_be(self) -> str:
        """The form."""
        return self.form

    def accepts(self, value: Any) -> bool:
        """Return whether the function reads a text."""
        try:
            return isinstance(value, str) and bool(self.read_text(value))
        except SetcmasError:
            return False


@dataclass(frozen=True)
class PathTo(Kind):
    """Files or folders."""

    metavar: str | None = field(default='FILE', kw_only=True)

    must_be = 'a path'

    def value(self, given: Any) -> Any:
        """Return the path in a text; an empty text has none."""
        return Path(given) if isinstance(given, str) and given else given

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a path."""
        return isinstance(value, Path)

    def located(self, value: Any, place: Callable[[str], str]) -> Any:
        """Return the file in its place."""
        return place(value) if isinstance(value, str) else value


@dataclass(frozen=True)
class NameOrFile(Kind):
    """Names and files, also some for each robot: '1:burger,2-4:my_robot.py'."""

    def value(self, given: Any) -> Any:
        """Return a path as a text."""
        return str(given) if isinstance(given, Path) else given

    def located(self, value: Any, place: Callable[[str], str]) -> Any:
        """Return the files in their place."""
        return mapped(value, place, 'it') if isinstance(value, str) else value


@dataclass(frozen=True)
class ScriptOrFunction(NameOrFile):
    """A script; in Python also a function, or a function for each robot."""

    def accepts(self, value: Any) -> bool:
        """Return whether there is a value: what it must be is checked where it is loaded."""
        return value is not None


@dataclass(frozen=True)
class Robots(Kind):
    """Robots by number: a sorted tuple, typed as '1-4' or '2,5-7'."""

    metavar: str | None = field(default='LIST', kw_only=True)

    must_be = "numbers from 1 and ranges, such as '1-4' or '2,5-7'"

    def value(self, given: Any) -> Any:
        """Return the numbers in a text or a list as a tuple."""
        try:
            given = parse_robots(given) if isinstance(given, str) else given
        except SetcmasError:
            return given
        return tuple(given) if isinstance(given, list) else given

    def accepts(self, value: Any) -> bool:
        """Return whether a value is a tuple of numbers."""
        return isinstance(value, tuple)
