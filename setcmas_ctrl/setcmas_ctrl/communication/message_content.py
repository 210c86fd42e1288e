"""Content of messages between robots: values that control laws send, and their layout as numbers.

A value is a finite number, an array of up to two dimensions, or a flat dictionary of names to
these; at most MOST_NUMBERS numbers and MOST_NAMES names.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import isfinite, prod
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from setcmas_ctrl.laws.script_errors import short_repr
from setcmas_ctrl.laws.script_function import unmasked
from setcmas_simu.arrays import Floats

MOST_NUMBERS, MOST_NAMES = 64, 16
"""Largest size of a value: a few hundred bytes, as a small radio packet carries."""

_LONGEST_NAME = 40
_MUST = (
    'it must be a finite number, an array of numbers with up to 2 dimensions, or a flat dict of '
    'names to these'
)

Plain = float | Floats
Value = Plain | Mapping[str, Plain]
"""What robots send."""


@dataclass(frozen=True, eq=False)
class Message:
    """The last value that a robot has received from another.

    Attributes:
        value: The value; arrays are numpy arrays of floats.
        age: Time since the sender's law sent it, in s.
        t: Time of that call of the sender's law, in s.
    """

    value: Any
    age: float
    t: float


class Content(NamedTuple):
    """A value, and the time t of the call of the law that sent it, in s."""

    t: float
    value: Value


def checked_value(given: Any) -> Value:
    """Return a copy of a value; its arrays are read-only.

    Raises:
        TypeError: It is no number, array or dictionary that can be sent.
        ValueError: It has too many numbers or names, or a number is not finite.
    """
    if not isinstance(given, Mapping):
        return _checked_numbers(given, given)
    if not 1 <= len(given) <= MOST_NAMES:
        raise ValueError(
            f'network.send got a dict with {len(given)} names; it must have 1 to {MOST_NAMES}'
        )
    values = {_checked_name(name): _checked_numbers(one, given) for name, one in given.items()}
    _check_size(sum(map(np.size, values.values())))
    return values


def read_only(value: Value | None) -> Value | None:
    """Return a value, or None, as scripts may have it: they cannot change it."""
    return MappingProxyType(value) if isinstance(value, Mapping) else value


def _checked_name(name: Any) -> str:
    if isinstance(name, str) and name.isidentifier() and len(name) <= _LONGEST_NAME:
        return str(name)
    raise TypeError(
        f'network.send got the name {short_repr(name)} in a dict; it must be a string such as '
        f"'x_1', of at most {_LONGEST_NAME} letters, digits and _"
    )


def _checked_numbers(numbers: Any, given: Any) -> Plain:
    try:
        array = np.asarray(unmasked(numbers))
    except ValueError:  # lists of unequal lengths
        array = np.empty(0, dtype=object)
    if array.dtype.kind not in 'iufb' or array.ndim > 2:
        raise TypeError(f'network.send got {short_repr(given)}; {_MUST}')
    _check_size(array.size)
    floats = array.astype(float)
    if not np.isfinite(floats).all():
        raise ValueError(f'network.send got {short_repr(given)}, which is not finite; {_MUST}')
    if not array.ndim:
        return float(floats)
    return np.frombuffer(floats.tobytes()).reshape(floats.shape)


def _check_size(size: int) -> None:
    if not 1 <= size <= MOST_NUMBERS:
        raise ValueError(
            f'network.send got {size} numbers; it must get 1 to {MOST_NUMBERS} at a time'
        )


class Dimension(NamedTuple):
    """A dimension of a value, as in std_msgs/MultiArrayDimension.

    Attributes:
        label: Name of the value in its dictionary; '' without a dictionary.
        size: Length of the array in this dimension; 1 for a number.
        stride: Count of numbers in this and the following dimensions; 0 for a number.
    """

    label: str
    size: int
    stride: int


def layout(value: Value) -> tuple[list[Dimension], list[float]]:
    """Return the dimensions of a value, and its numbers, the last dimension running fastest."""
    dimensions: list[Dimension] = []
    numbers: list[float] = []
    for name, one in value.items() if isinstance(value, Mapping) else [('', value)]:
        shape = np.shape(one)
        sizes = [Dimension(name, size, prod(shape[i:])) for i, size in enumerate(shape)]
        dimensions += sizes or [Dimension(name, 1, 0)]
        numbers += np.ravel(one).tolist()
    return dimensions, numbers


def value_of(dimensions: Iterable[Any], numbers: Sequence[float]) -> Value:
    """Return the value of a layout: dimensions with label, size and stride, and numbers.

    Raises:
        TypeError, ValueError: They are not the layout of a value.
    """
    values: dict[str, Any] = {}
    rest = list(numbers)
    for name, own in groupby(dimensions, attrgetter('label')):
        first, *others = own
        shape = (first.size, *(one.size for one in others)) if first.stride else ()
        values[name] = np.reshape(rest[: prod(shape)], shape)
        del rest[: prod(shape)]
    if rest:
        raise ValueError(f'{len(rest)} of {len(numbers)} numbers have no dimension')
    return checked_value(values[''] if list(values) == [''] else values)


def content_of(dimensions: Iterable[Any], offset: int, data: Iterable[float]) -> Content:
    """Return the content in the numbers of a message: a time, and a value from an offset on.

    Raises:
        TypeError, ValueError: They are something else.
    """
    numbers = [float(number) for number in data]
    if not numbers or not isfinite(numbers[0]) or offset < 1:
        raise ValueError('it must begin with a time in s, and data_offset must be at least 1')
    return Content(numbers[0], value_of(dimensions, numbers[offset:]))
