"""Columns of a message type: one for a field, and one for each element of an array."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

LONGEST_ARRAY = 10_000
"""Longer arrays, such as images, get one column with their length instead of one an element."""

_TOO_LONG = -1

Column: TypeAlias = tuple[tuple[float, ...], str]
"""Place of a column among all that messages of the type can have, for sorting, and its name."""

Lengths: TypeAlias = tuple[int, ...]
"""Lengths of all arrays of a message, in the order of its fields; they tell its columns."""


class Part(Protocol):
    """What one field adds to a table."""

    def read(self, message: Any, cells: list[Any], lengths: list[int], /) -> None:
        """Append the field's cells, and the lengths of the arrays in it."""

    def columns(self, lengths: Iterator[int], /) -> Iterator[Column]:
        """Yield the field's columns; takes the lengths of its arrays."""


@dataclass(frozen=True)
class Field:
    """A field with one value."""

    name: str
    cell: Callable[[Any], Any]
    """Makes the cell of a message."""

    def read(self, message: Any, cells: list[Any], _lengths: list[int], /) -> None:
        """Append the value."""
        cells.append(self.cell(message))

    def columns(self, _lengths: Iterator[int], /) -> Iterator[Column]:
        """Yield the one column."""
        yield (), self.name


@dataclass(frozen=True)
class Array:
    """An array of values, or of messages."""

    name: str
    elements: Callable[[Any], Sequence[Any]]
    """Returns the array of a message."""
    cells: Callable[[Any], list[Any]] | None
    """Makes the cells of an array of values."""
    parts: Sequence[Part] = ()
    """The fields of each element of an array of messages."""

    def read(self, message: Any, cells: list[Any], lengths: list[int]) -> None:
        """Append the elements, or how many they are."""
        elements = self.elements(message)
        if len(elements) > LONGEST_ARRAY:
            lengths.append(_TOO_LONG)
            cells.append(len(elements))
            return
        lengths.append(len(elements))
        if self.cells:
            cells += self.cells(elements)
            return
        for element in elements:
            for part in self.parts:
                part.read(element, cells, lengths)

    def columns(self, lengths: Iterator[int]) -> Iterator[Column]:
        """Yield the columns of each element, or that of the length."""
        length = next(lengths)
        if length == _TOO_LONG:
            yield (math.inf,), f'{self.name}.length'
        for i in range(length):
            if self.cells:
                yield (i,), f'{self.name}[{i}]'
            else:
                for place, name in columns(self.parts, lengths):
                    yield (i, *place), f'{self.name}[{i}].{name}'


def columns(parts: Sequence[Part], lengths: Iterator[int]) -> Iterator[Column]:
    """Yield the columns of a message with arrays of these lengths."""
    for i, part in enumerate(parts):
        for place, name in part.columns(lengths):
            yield (i, *place), name
