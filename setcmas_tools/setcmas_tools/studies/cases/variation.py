"""Variation of a name in a study: lists, ranges and random draws, read from a text."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

_NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
_RANGE = re.compile(rf'(log:)?({_NUMBER}):({_NUMBER}):(\d+)')
_DRAW = re.compile(rf'(uniform|loguniform|normal):({_NUMBER}):({_NUMBER})(?::(\d+))?')
_MISTAKEN = re.compile(
    rf'(?:(?:log|uniform|loguniform|normal):{_NUMBER}|{_NUMBER}:{_NUMBER})(?::{_NUMBER})*'
)
_DIGITS = 12  # so that 0.2:2:10 has 0.4 and not 0.4000000000000001

FORM = (
    'a list (0,0.2,0.4), a range FIRST:LAST:COUNT or log:FIRST:LAST:COUNT, or random draws '
    'uniform:LOW:HIGH, loguniform:LOW:HIGH or normal:MEAN:DEVIATION, for each run or with :COUNT'
)
"""What a variation must be."""


@dataclass(frozen=True)
class Draw:
    """A number that every run draws for itself.

    Attributes:
        kind: 'uniform', 'loguniform' or 'normal'.
        first: The lower bound, or the mean.
        second: The upper bound, or the standard deviation.
    """

    kind: str
    first: float
    second: float

    def __str__(self) -> str:
        """Return the text that means it."""
        return f'{self.kind}:{self.first:g}:{self.second:g}'

    def numbers(self, count: int, *seed: int) -> list[float]:
        """Return so many numbers; equal seeds give equal ones."""
        generator = np.random.default_rng(seed)
        if self.kind == 'normal':
            return _tidy(generator.normal(self.first, self.second, count))
        if self.kind == 'uniform':
            return _tidy(generator.uniform(self.first, self.second, count))
        low, high = math.log(self.first), math.log(self.second)
        return _tidy(np.exp(generator.uniform(low, high, count)))


def parse_variation(name: str, text: str, seed: int) -> Draw | list[Any]:
    """Return the values that a text such as '0.2:2:10' means, or the draw of each run.

    Values of a list stay texts unless the list is YAML, such as '[[1, 2], [3, 4]]'.

    Args:
        name: What is varied.
        text: The text.
        seed: Chooses the values of a draw with a count.

    Raises:
        SetcmasError: The text has another form.
    """
    if found := _RANGE.fullmatch(text):
        return _range(name, text, bool(found[1]), float(found[2]), float(found[3]), int(found[4]))
    if found := _DRAW.fullmatch(text):
        draw = _checked(Draw(found[1], float(found[2]), float(found[3])), name)
        return draw.numbers(int(found[4]), seed, *name.encode()) if found[4] else draw
    values = _yaml_list(text) if text.startswith('[') else text.split(',')
    empty = not values or not all(str(value).strip() for value in values)
    if empty or _MISTAKEN.fullmatch(text):
        raise SetcmasError(f"--vary {name} '{text}' must be {FORM}")
    return [value.strip() if isinstance(value, str) else value for value in values]


def _range(name: str, text: str, log: bool, first: float, last: float, count: int) -> list[float]:
    if count < 1 or (log and not (first > 0 and last > 0)):
        more = ' with bounds above 0' if log else ''
        raise SetcmasError(f"--vary {name} '{text}' must be a range of 1 value or more{more}")
    if log:
        return _tidy(np.geomspace(first, last, count))
    return _tidy(np.linspace(first, last, count))


def _checked(draw: Draw, name: str) -> Draw:
    least = 0.0 if draw.kind == 'normal' else draw.first
    if draw.second < least or (draw.kind == 'loguniform' and draw.first <= 0):
        raise SetcmasError(
            f"--vary {name} '{draw}' must have bounds in order, above 0 for loguniform, and a "
            'deviation of at least 0'
        )
    return draw


def _tidy(numbers: Floats) -> list[float]:
    return [float(f'{number:.{_DIGITS}g}') for number in numbers.tolist()]


def _yaml_list(text: str) -> Sequence[Any]:
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError:
        return []
    return values if isinstance(values, list) else []
