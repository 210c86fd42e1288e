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

from setcmas_tools.bags.bag_sources import one_line
from setcmas_tools.bags.type_limits import MOST_LETTERS, TooLargeError, TypeLimits

_MOST_LETTERS = 20 * MOST_LETTERS
_MOST_STORES = 50
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
        """Start without any type."""
        # More than one store only if topics disagree on a definition, as in merged bags.
        self._stores: list[Typestore] = []
        self._letters = 0
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
            store = self._store_for(connection)
            decode = _decoder(store, connection.msgtype, is_ros1)
            self._resolved[key] = MessageType(connection.msgtype, store, decode)
        return self._resolved[key]

    def _store_for(self, connection: Connection) -> Typestore:
        if connection.msgdef.format == MessageDefinitionFormat.NONE:
            return _store_of_ros(connection.msgtype)
        self._letters += len(connection.msgdef.data)
        if self._letters > _MOST_LETTERS or len(self._stores) > _MOST_STORES:
            raise UnresolvedTypeError('the definitions in the bag are too long or too many')
        definitions = _parse(connection)
        fresh = get_typestore(Stores.EMPTY)
        for store in (*self._stores, fresh):
            try:
                store.register(definitions)
            except (TypesysError, SyntaxError) as error:  # the latter from a damaged name
                reason = one_line(error)
                continue
            if store is fresh:
                self._stores.append(fresh)
            return store
        raise UnresolvedTypeError(f'its definition is damaged ({reason})')


def _store_of_ros(msgtype: str) -> Typestore:
    # Bags hold definitions since Iron (mcap: Humble), so those without are Humble's or older.
    store = get_typestore(Stores.ROS2_HUMBLE)
    if msgtype not in store.fielddefs:
        raise UnresolvedTypeError('the bag holds no definition of it')
    return store


def _parse(connection: Connection) -> dict[str, Any]:
    text = connection.msgdef.data
    if len(text) > MOST_LETTERS:
        raise UnresolvedTypeError(
            f'its definition has {len(text):,} letters; at most {MOST_LETTERS:,} are read'
        )
    try:
        if connection.msgdef.format == MessageDefinitionFormat.MSG:
            return dict(get_types_from_msg(text, connection.msgtype))
        definitions: dict[str, Any] = {}
        for part in text.split(_IDL_SEPARATOR):
            idl = part.split('\n', 1)[1] if part.startswith('IDL: ') else part
            if idl.strip():
                definitions.update(get_types_from_idl(idl))
    except (TypesysError, ValueError, RecursionError) as error:
        raise UnresolvedTypeError(f'its definition is damaged ({one_line(error)})') from error
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
