"""Columns of messages with arrays of varying length: their names, and how rows are filled up."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice, repeat, zip_longest
from typing import Any, TypeAlias

LONGEST_ARRAY = 10_000
"""Longer arrays, such as images, get one column with their length instead of one an element."""

Shape: TypeAlias = tuple[Any, ...]
"""The lengths of the arrays of a message, one entry for each `Repeated` and each `Nested`.

An entry is a pair. Its first part is the number of elements, of a `Nested` the tuple of their
shapes; its second part is whether an array is so long that it has one column, its length.
"""


@dataclass(frozen=True)
class Fixed:
    """Columns that every message of the type has."""

    names: tuple[str, ...]


@dataclass(frozen=True)
class Repeated:
    """An array of numbers, of strings or of messages that are all `Fixed`."""

    name: str
    element: tuple[str, ...]
    """What follows `name[0]` in the names of its columns: '' for numbers, '.x' and so on."""


@dataclass(frozen=True)
class Nested:
    """An array of messages that hold arrays of varying length themselves."""

    name: str
    items: tuple[Item, ...]


Item: TypeAlias = Fixed | Repeated | Nested


def count_entry(array: Sequence[Any]) -> tuple[int, bool]:
    """Return the entry of a `Repeated` in a shape."""
    length = len(array)
    return (0, True) if length > LONGEST_ARRAY else (length, False)


def shapes_entry(
    messages: Sequence[Any], shape: Callable[[Any], Shape]
) -> tuple[tuple[Shape, ...], bool]:
    """Return the entry of a `Nested` in a shape, given what makes the shape of one message."""
    if len(messages) > LONGEST_ARRAY:
        return (), True
    return tuple([shape(message) for message in messages]), False


def column_names(items: Sequence[Item], shape: Shape, prefix: str = '') -> Iterator[str]:
    """Yield the names of the columns of messages of a shape."""
    entries = iter(shape)
    for item in items:
        if isinstance(item, Fixed):
            yield from (prefix + name for name in item.names)
            continue
        content, is_long = next(entries)
        name = prefix + item.name
        if isinstance(item, Repeated):
            yield from (f'{name}[{i}]{part}' for i in range(content) for part in item.element)
        else:
            for i, inner in enumerate(content):
                yield from column_names(item.items, inner, f'{name}[{i}].')
        if is_long:
            yield f'{name}.length'


def union(a: Shape, b: Shape) -> Shape:
    """Return the smallest shape that has all columns of two shapes of the same type."""
    return tuple(
        (_union_of_contents(content_a, content_b), long_a or long_b)
        for (content_a, long_a), (content_b, long_b) in zip(a, b, strict=True)
    )


def _union_of_contents(a: Any, b: Any) -> Any:
    if isinstance(a, int):
        return max(a, b)
    return tuple(y if x is None else x if y is None else union(x, y) for x, y in zip_longest(a, b))


def fill_up(
    items: Sequence[Item], shape: Shape, wider: Shape, cells: Iterator[str]
) -> Iterator[str]:
    """Yield the cells of a row with an empty one for each column that the row lacks.

    Args:
        items: The columns of the type.
        shape: The shape of the row.
        wider: A shape that has all its columns and more.
        cells: The cells of the row.
    """
    entries = zip(shape, wider, strict=True)
    for item in items:
        if isinstance(item, Fixed):
            yield from islice(cells, len(item.names))
            continue
        (content, is_long), (wider_content, wider_is_long) = next(entries)
        if isinstance(item, Repeated):
            yield from islice(cells, content * len(item.element))
            yield from repeat('', (wider_content - content) * len(item.element))
        else:
            for inner, wider_inner in zip_longest(content, wider_content):
                yield from _fill_up_element(item.items, inner, wider_inner, cells)
        if wider_is_long:
            yield next(cells) if is_long else ''


def _fill_up_element(
    items: Sequence[Item], shape: Shape | None, wider: Shape, cells: Iterator[str]
) -> Iterator[str]:
    if shape is not None:
        return fill_up(items, shape, wider, cells)
    return chain.from_iterable(repeat(('',), sum(1 for _ in column_names(items, wider))))
