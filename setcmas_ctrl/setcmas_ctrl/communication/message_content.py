"""Content of messages between robots: values that control laws send, as JSON over ROS.

A value is a finite number, an array of up to two dimensions, or a flat dictionary of names to
these; at most MOST_NUMBERS numbers and MOST_NAMES names.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
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


def plain(value: Value) -> Any:
    """Return a value as numbers, lists and dictionaries, for JSON."""
    if isinstance(value, Mapping):
        return {name: plain(one) for name, one in value.items()}
    return np.asarray(value).tolist()


def encoded(content: Content) -> str:
    """Return content as JSON, such as {"t": 4.2, "value": {"x": 1.5, "goal": [2, 3]}}."""
    return json.dumps({'t': content.t, 'value': plain(content.value)})


def decoded(text: str) -> Content:
    """Return the content that a JSON text holds.

    Raises:
        TypeError, ValueError: The text holds no content.
    """
    try:
        message = json.loads(text)
        if isinstance(message, dict) and message.keys() == {'t', 'value'}:
            t, value = checked_value(message['t']), checked_value(message['value'])
            if isinstance(t, float):
                return Content(t, value)
    except RecursionError:
        pass
    raise ValueError('it must be a JSON object with t, a time in s, and value')


class Mailbox:
    """Messages of calls outside a run: an exchange that keeps what a robot sends.

    Attributes:
        t: Time of the call in s.
        are_used: Whether the law uses messages.
        sent: The value that it sends.
    """

    def __init__(self, t: float, contents: Mapping[int, Content]) -> None:
        """Take what the robot has received at a time in s, by sender."""
        self.t = t
        self.are_used = False
        self.sent: Value | None = None
        self._contents = contents

    def begin(self) -> None:
        """Note that the law uses messages."""
        self.are_used = True

    def send(self, robot: int, value: Value) -> None:
        """Keep the value that the law sends."""
        del robot
        self.sent = value

    def received(self, robot: int) -> Mapping[int, Content]:
        """Return what the robot has received."""
        del robot
        return self._contents
