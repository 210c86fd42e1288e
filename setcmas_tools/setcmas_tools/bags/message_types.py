"""Types of messages: their definitions, as bags store and need them."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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

from setcmas_tools.bags.bag_file import one_line

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
            try:
                self._resolved[key] = self._type_of(connection, is_ros1)
            except KeyError as error:  # of a type or of a kind of field
                raise UnresolvedTypeError(f'no definition of {error} is known') from error
            except RecursionError as error:
                raise UnresolvedTypeError('its definition contains itself') from error
        return self._resolved[key]

    def _type_of(self, connection: Connection, is_ros1: bool) -> MessageType:
        # Bags hold definitions since Iron (mcap: Humble), so those without are Humble's or older.
        known = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
        name = connection.msgtype
        try:
            store = _store_of(_parsed(connection), known)
            # SyntaxError: of a damaged name
        except (TypesysError, SyntaxError, ValueError) as error:
            store = known
            if name not in store.fielddefs:
                reason = f'its definition is damaged ({one_line(error)})'
                if not connection.msgdef.data:
                    reason = 'the bag holds no definition of it'
                raise UnresolvedTypeError(reason) from error
        store.get_msgdef(name)
        deserialise = store.deserialize_ros1 if is_ros1 else store.deserialize_cdr

        def decode(data: bytes) -> Any:
            try:
                return deserialise(data, name)
            except SerdeError as error:
                raise UndecodableError(one_line(error)) from error

        return MessageType(name, store, decode)


def _store_of(types: dict[str, Any], known: Typestore) -> Typestore:
    """Return a store of types and of their parts, which bags of other tools may lack."""
    _add_parts(types, lambda part: {part: known.fielddefs[part]})
    store = get_typestore(Stores.EMPTY)
    store.register(types)
    return store


def _parsed(connection: Connection) -> dict[str, Any]:
    """Return the definitions of a type and its parts; ValueError is raised if there are none."""
    text = connection.msgdef.data
    if connection.msgdef.format == MessageDefinitionFormat.MSG and text:
        return dict(get_types_from_msg(text, connection.msgtype))
    definitions: dict[str, Any] = {}
    for part in text.split(_IDL_SEPARATOR):
        idl = part.split('\n', 1)[1] if part.startswith('IDL: ') else part
        if idl.strip():
            definitions.update(get_types_from_idl(idl))
    if not definitions:
        raise ValueError
    return definitions


class UnknownDefinitionError(Exception):
    """A message type with no definition on this machine."""


@dataclass(frozen=True)
class Definition:
    """Definition of a type and its parts, as a bag stores it, and its hash, RIHS01_...."""

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
        known = self.store.fielddefs
        found = {} if msgtype in known else self._installed(msgtype)
        _add_parts(found, lambda part: {} if part in known else self._installed(part))
        return found

    def _installed(self, msgtype: str) -> dict[str, Any]:
        for prefix in self._prefixes:
            path = prefix / 'share' / f'{msgtype}.msg'
            if path.is_file():
                return dict(get_types_from_msg(path.read_text(encoding='utf-8'), msgtype))
        raise UnknownDefinitionError(f'no file {msgtype}.msg is installed')


def installed_prefixes() -> list[Path]:
    """Return the folders in which ROS packages are installed: sourced ones, then Python's."""
    sourced = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [*(Path(prefix) for prefix in sourced if prefix), Path(sys.prefix)]


def _add_parts(types: dict[str, Any], find: Callable[[str], dict[str, Any]]) -> None:
    """Add the definitions of the parts of types, and of their parts, that a function finds."""
    waiting = list(types)
    while waiting:
        for _, desc in types[waiting.pop()][1]:
            for part in _part_names(desc):
                if part not in types:
                    new = find(part)
                    types |= new
                    waiting += new


def _part_names(desc: Any) -> list[str]:
    kind, detail = desc
    if kind == Nodetype.NAME:
        return [detail]
    return _part_names(detail[0]) if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else []
