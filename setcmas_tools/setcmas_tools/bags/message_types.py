"""Types of messages: their definitions, as bags store and need them."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.interfaces import (
    Connection,
    ConnectionExtRosbag1,
    ConnectionExtRosbag2,
    MessageDefinitionFormat,
    Nodetype,
)
from rosbags.serde import SerdeError
from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)
from rosbags.typesys.store import Typestore

from setcmas_tools.bags.bag_sources import one_line

_MOST_LETTERS = 100_000  # of the definition of a type with its parts
_MOST_TYPES = 500
_IDL_SEPARATOR = '=' * 80 + '\n'


class UnresolvedTypeError(Exception):
    """A message type that cannot be decoded; the message has the reason."""


class UndecodableError(Exception):
    """The bytes of a message do not fit its type."""


@dataclass(frozen=True)
class MessageType:
    """A message type that can be decoded.

    Attributes:
        name: As in `nav_msgs/msg/Odometry`.
        store: The definitions of this type and its parts.
        decode: Makes a message object from its bytes; raises UndecodableError.
    """

    name: str
    store: Typestore
    decode: Callable[[bytes], Any]


class BagTypes:
    """Resolves the types of a bag."""

    def __init__(self) -> None:
        self._resolved: dict[tuple[str, str, bool], MessageType] = {}
        # Decoders of a part are made once; topics that disagree on it, as in merged bags, have
        # stores of their own.
        self._shared = get_typestore(Stores.EMPTY)

    def resolve(self, connection: Connection) -> MessageType:
        """Return the type of a connection's messages.

        Raises:
            UnresolvedTypeError: No usable definition of the type exists.
        """
        ext = connection.ext
        is_ros1 = isinstance(ext, ConnectionExtRosbag1)
        if isinstance(ext, ConnectionExtRosbag2) and ext.serialization_format != 'cdr':
            encoding = ext.serialization_format
            raise UnresolvedTypeError(f"it is encoded as '{encoding}'; it must be cdr")
        key = (connection.msgtype, connection.msgdef.data, is_ros1)
        if key not in self._resolved:
            letters = sum(len(text) for _, text, _ in self._resolved)
            if letters > 20 * _MOST_LETTERS or len(self._resolved) > _MOST_TYPES:
                raise UnresolvedTypeError('the definitions in the bag are too long or too many')
            store = self._store_for(connection)
            decode = _decoder(store, connection.msgtype, is_ros1)
            self._resolved[key] = MessageType(connection.msgtype, store, decode)
        return self._resolved[key]

    def _store_for(self, connection: Connection) -> Typestore:
        if connection.msgdef.format == MessageDefinitionFormat.NONE:
            return _store_of_ros(connection.msgtype)
        try:
            types = _parse(connection)
            with suppress(TypesysError):
                self._shared.register(types)
                return self._shared
            store = get_typestore(Stores.EMPTY)
            store.register(types)
        # SyntaxError: of a damaged name
        except (TypesysError, SyntaxError, ValueError, RecursionError) as error:
            raise UnresolvedTypeError(f'its definition is damaged ({one_line(error)})') from error
        return store


def _store_of_ros(msgtype: str) -> Typestore:
    # Bags hold definitions since Iron (mcap: Humble), so those without are Humble's or older.
    store = get_typestore(Stores.ROS2_HUMBLE)
    if msgtype not in store.fielddefs:
        raise UnresolvedTypeError('the bag holds no definition of it')
    return store


def _parse(connection: Connection) -> dict[str, Any]:
    text = connection.msgdef.data
    if len(text) > _MOST_LETTERS:
        raise UnresolvedTypeError(
            f'its definition has {len(text):,} letters; at most {_MOST_LETTERS:,} are read'
        )
    if connection.msgdef.format == MessageDefinitionFormat.MSG:
        return dict(get_types_from_msg(text, connection.msgtype))
    definitions: dict[str, Any] = {}
    for part in text.split(_IDL_SEPARATOR):
        idl = part.split('\n', 1)[1] if part.startswith('IDL: ') else part
        if idl.strip():
            definitions.update(get_types_from_idl(idl))
    return definitions


def _decoder(store: Typestore, msgtype: str, is_ros1: bool) -> Callable[[bytes], Any]:
    try:
        limits = TypeLimits(store.fielddefs, msgtype)
        store.get_msgdef(msgtype)
    except TooLargeError as error:
        raise UnresolvedTypeError(str(error)) from error
    except KeyError as error:  # of a type or of a kind of field
        raise UnresolvedTypeError(f'no definition of {error} is known') from error
    deserialise = store.deserialize_ros1 if is_ros1 else store.deserialize_cdr

    def decode(data: bytes) -> Any:
        try:
            limits.check(data)
            return deserialise(data, msgtype)
        except (SerdeError, TooLargeError) as error:
            raise UndecodableError(one_line(error)) from error

    return decode


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
            if depth > _DEEPEST:
                raise TooLargeError(f'it is nested deeper than {_DEEPEST} levels')
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


class UnknownDefinitionError(Exception):
    """A message type with no definition on this machine."""


@dataclass(frozen=True)
class Definition:
    """Definition of a type, as a bag stores it.

    Attributes:
        text: The definition, followed by those of its parts.
        digest: The hash of both, as in RIHS01_....
    """

    text: str
    digest: str


class MessageDefinitions:
    """Finds definitions: those of ROS 2 Jazzy are built in, others are installed .msg files.

    Attributes:
        store: The types with a known definition.
    """

    def __init__(self, prefixes: list[Path] | None = None) -> None:
        """Start with the built-in ones.

        Args:
            prefixes: Folders that hold `share/<package>/msg/<name>.msg`; by default those of the
                sourced ROS workspaces and of this Python environment.
        """
        self._prefixes = installed_prefixes() if prefixes is None else prefixes
        self.store = get_typestore(Stores.ROS2_JAZZY)

    def of(self, msgtype: str) -> Definition:
        """Return the definition of a type such as `nav_msgs/msg/Odometry`.

        Raises:
            UnknownDefinitionError: It is neither built in nor installed, or is malformed.
        """
        try:
            self.store.register(self._missing(msgtype))
            text, _ = self.store.generate_msgdef(msgtype, ros_version=2)
            return Definition(text, self.store.hash_rihs01(msgtype))
        except (TypesysError, KeyError) as error:
            raise UnknownDefinitionError(f'its definition is malformed: {error}') from error

    def _missing(self, msgtype: str) -> dict[str, Any]:
        """Return the parsed definitions of a type and its parts that are not built in."""
        found: dict[str, Any] = {}
        waiting = [msgtype]
        while waiting:
            name = waiting.pop()
            if name not in found and name not in self.store.fielddefs:
                found |= get_types_from_msg(self._text(name), name)
                waiting += [part for _, desc in found[name][1] for part in _part_names(desc)]
        return found

    def _text(self, msgtype: str) -> str:
        for prefix in self._prefixes:
            path = prefix / 'share' / f'{msgtype}.msg'
            if path.is_file():
                return path.read_text(encoding='utf-8')
        raise UnknownDefinitionError(f'no file {msgtype}.msg is installed')


def installed_prefixes() -> list[Path]:
    """Return the folders in which ROS packages are installed: sourced ones, then Python's."""
    sourced = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [*(Path(prefix) for prefix in sourced if prefix), Path(sys.prefix)]


def _part_names(desc: Any) -> list[str]:
    kind, detail = desc
    if kind == Nodetype.NAME:
        return [detail]
    return _part_names(detail[0]) if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else []
