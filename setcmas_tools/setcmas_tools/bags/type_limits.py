"""Limits of message types: a definition from a stranger must not take much memory or time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype

MOST_LETTERS = 100_000
"""Longest definition of a type with its parts."""

_DEEPEST = 30
_MOST_COLUMNS = 10_000
_MOST_ELEMENTS = 2_000_000  # of a message: each is an object of Python
_BYTES = {'bool': 1, 'byte': 1, 'char': 1, 'int8': 1, 'uint8': 1, 'int16': 2, 'uint16': 2}


class TooLargeError(Exception):
    """A type or a message exceeds a limit; the message says which."""


class _Size(NamedTuple):
    depth: int
    columns: int
    bytes: int


class TypeLimits:
    """Sizes of a type's messages, as its definition gives them."""

    def __init__(self, fields: Mapping[str, Any], msgtype: str) -> None:
        """Go through the parts of a type.

        Args:
            fields: Definitions by type, as rosbags parses them.
            msgtype: Name of the type.

        Raises:
            TooLargeError: It contains itself, is nested too deep, or has too many fields.
        """
        self._fields = fields
        self._sizes: dict[str, _Size | None] = {}
        self._smallest: float = math.inf
        self._size(msgtype, 0)

    def check(self, data: bytes) -> None:
        """Check a message before it is decoded.

        Raises:
            TooLargeError: It may have too many elements in arrays of texts or of messages.
        """
        if len(data) > self._smallest * _MOST_ELEMENTS:
            raise TooLargeError(f'it may have more than {_MOST_ELEMENTS:,} elements')

    def _size(self, msgtype: str, depth: int) -> _Size:
        if msgtype not in self._fields:  # this is reported later
            return _Size(0, 1, 1)
        known = self._sizes.get(msgtype, _Size(0, 0, 0) if msgtype not in self._sizes else None)
        if known is None:
            raise TooLargeError(f'{msgtype} contains itself')
        if msgtype not in self._sizes:
            self._sizes[msgtype] = None
            parts = [self._part(field, depth + 1) for _, field in self._fields[msgtype][1]]
            known = _Size(
                1 + max((part.depth for part in parts), default=0),
                sum(part.columns for part in parts),
                sum(part.bytes for part in parts),
            )
            self._sizes[msgtype] = known
        if depth + known.depth > _DEEPEST:
            raise TooLargeError(f'it is nested deeper than {_DEEPEST} levels')
        if known.columns > _MOST_COLUMNS:
            raise TooLargeError(f'it has more than {_MOST_COLUMNS:,} fields')
        return known

    def _part(self, field: tuple[Any, Any], depth: int) -> _Size:
        if depth > _DEEPEST:
            raise TooLargeError(f'it is nested deeper than {_DEEPEST} levels')
        kind, detail = field
        if kind == Nodetype.NAME:
            return self._size(detail, depth)
        if kind == Nodetype.BASE:
            return _Size(0, 1, _BYTES.get(detail[0], 4))
        element, length = detail
        size = self._part(element, depth)
        times = length if kind == Nodetype.ARRAY else 1
        if element[0] == Nodetype.NAME or element[1][0] == 'string':
            self._smallest = min(self._smallest, size.bytes)
            size = size._replace(columns=times * size.columns)
        return size._replace(bytes=times * size.bytes if kind == Nodetype.ARRAY else 4)
