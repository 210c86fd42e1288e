"""Values of messages as the text of CSV cells."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_tools.tables.columns import LONGEST_ARRAY

_NANO = 1_000_000_000


def seconds_text(nanoseconds: int) -> str:
    """Return a time or a duration in s with 9 decimals, without rounding."""
    sign = '-' if nanoseconds < 0 else ''
    seconds, rest = divmod(abs(nanoseconds), _NANO)
    return f'{sign}{seconds}.{rest:09d}'


def stamp_text(stamp: Any) -> str:
    """Return a builtin_interfaces Time or Duration in s with 9 decimals."""
    return seconds_text(stamp.sec * _NANO + stamp.nanosec)


@lru_cache(maxsize=4096)
def float32_text(value: float) -> str:
    """Return the shortest text that gives this single-precision number, such as 0.1."""
    return repr(float(str(np.float32(value))))


@lru_cache(maxsize=4096)
def quoted(text: str) -> str:
    """Return text as a CSV cell, in quotes only where it needs them."""
    if any(character in text for character in ',"\r\n'):
        return '"' + text.replace('"', '""') + '"'
    return text


def cells_of_strings(strings: list[str]) -> str:
    """Return the cells of an array of strings, each after a comma."""
    if len(strings) > LONGEST_ARRAY:
        return f',{len(strings)}'
    return ''.join([f',{quoted(text)}' for text in strings])


def cells_of_messages(messages: list[Any], cells: Callable[[Any], str]) -> str:
    """Return the cells of an array of messages, given what makes those of one message."""
    if len(messages) > LONGEST_ARRAY:
        return f',{len(messages)}'
    return ''.join([cells(message) for message in messages])


def array_writer() -> Callable[[NDArray[Any]], str]:
    """Return a function that makes the cells of an array of numbers, each after a comma.

    It remembers the last array, since arrays such as covariances seldom change: use one function
    for each field.
    """
    last_bytes: bytes | None = None
    last_text = ''

    def cells(array: NDArray[Any]) -> str:
        nonlocal last_bytes, last_text
        if len(array) > LONGEST_ARRAY:
            return f',{len(array)}'
        content = array.tobytes()
        if content != last_bytes:
            last_text = ''.join([f',{text}' for text in _texts(array)])
            last_bytes = content
        return last_text

    return cells


def _texts(array: NDArray[Any]) -> Iterable[str]:
    if array.dtype == np.float32:
        return map(float32_text, array.tolist())
    if array.dtype == np.bool_:
        return map(str, array.astype(int).tolist())
    return map(repr, array.tolist())
