"""CSV cells of a message's values; `csv` writes numbers and text by itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

_NANO = 1_000_000_000
STAMPS = ('builtin_interfaces/msg/Time', 'builtin_interfaces/msg/Duration')


def seconds_text(nanoseconds: int) -> str:
    """Return a time or a duration in s with 9 decimals, without rounding."""
    sign = '-' if nanoseconds < 0 else ''
    seconds, rest = divmod(abs(nanoseconds), _NANO)
    return f'{sign}{seconds}.{rest:09d}'


def cell_of(kind: str) -> Callable[[Any], Any] | None:
    """Return what makes the cell of a value of a type; None if `csv` writes it as it is."""
    return _CELLS.get(kind)


def cells_of(kind: str) -> Callable[[Any], list[Any]]:
    """Return what makes the cells of an array with elements of a type."""
    return _ARRAYS.get(kind, _numbers)


def _stamp(stamp: Any) -> str:
    return seconds_text(stamp.sec * _NANO + stamp.nanosec)


@lru_cache(maxsize=4096)
def _float32(value: float) -> float:
    """Return the number whose text is the shortest for a single-precision one, such as 0.1."""
    return float(str(np.float32(value)))


def _numbers(array: NDArray[Any]) -> list[Any]:
    numbers: list[Any] = array.tolist()
    return numbers


def _stamps(stamps: Sequence[Any]) -> list[str]:
    return [_stamp(stamp) for stamp in stamps]


def _float32s(array: NDArray[np.float32]) -> list[float]:
    return [_float32(value) for value in array.tolist()]


def _bools(array: NDArray[np.bool_]) -> list[int]:
    return list(map(int, array))


_CELLS: dict[str, Callable[[Any], Any]] = {
    'bool': int,
    'float32': _float32,
    **dict.fromkeys(STAMPS, _stamp),
}
_ARRAYS: dict[str, Callable[[Any], list[Any]]] = {
    'bool': _bools,
    'float32': _float32s,
    'string': list,
    'wstring': list,
    **dict.fromkeys(STAMPS, _stamps),
}
