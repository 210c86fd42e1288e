"""Types of messages: their definitions, as bags store and need them."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection, MessageDefinitionFormat, Nodetype
from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)
from rosbags.typesys.store import Typestore

_IDL_SEPARATOR = '=' * 80 + '\n'
_LONGEST_REASON = 120


def one_line(error: Exception) -> str:
    """Return the message of a library's error in one line that fits a terminal."""
    text = ' '.join(str(error).split()) or 'inconsistent content'
    return text if len(text) <= _LONGEST_REASON else f'{text[:_LONGEST_REASON]} ...'


class UnknownDefinitionError(Exception):
    """A message type without a usable definition; the message has the reason."""


def add_type_of(connection: Connection, types: Typestore, is_ros1: bool) -> None:
    """Add the type of a bag's topic, and its parts, to the types that are known.

    What the bag does not define is taken from ROS.

    Raises:
        UnknownDefinitionError: There is no definition, it is malformed, or another topic has a
            different one.
    """
    # Bags hold definitions since Iron (mcap: Humble), so those without are Humble's or older.
    known = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE).fielddefs
    try:
        try:
            own = _parsed(connection)
        except (TypesysError, SyntaxError, ValueError):
            if connection.msgtype not in known:
                raise
            own = {}
        parts = _with_parts(connection.msgtype, lambda name: own.get(name) or known[name])
        types.register(parts)
        types.get_msgdef(connection.msgtype)
    except KeyError as error:  # of a type or of a kind of field
        raise UnknownDefinitionError(f'no definition of {error} is known') from error
    except RecursionError as error:
        raise UnknownDefinitionError('its definition contains itself') from error
    except (TypesysError, SyntaxError, ValueError) as error:  # SyntaxError: of a damaged name
        raise UnknownDefinitionError(f'its definition is damaged ({one_line(error)})') from error


def _parsed(connection: Connection) -> dict[str, Any]:
    """Return the definitions that a bag holds of a type and its parts; it may hold none."""
    text = connection.msgdef.data
    if not text:
        return {}
    if connection.msgdef.format == MessageDefinitionFormat.MSG:
        return dict(get_types_from_msg(text, connection.msgtype))
    definitions: dict[str, Any] = {}
    for part in text.split(_IDL_SEPARATOR):
        idl = part.split('\n', 1)[1] if part.startswith('IDL: ') else part
        if idl.strip():
            definitions.update(get_types_from_idl(idl))
    return definitions


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
        self._prefixes = _installed_prefixes() if prefixes is None else prefixes
        self.store = get_typestore(Stores.ROS2_JAZZY)

    def add(self, msgtype: str) -> None:
        """Find the definition of a type such as `nav_msgs/msg/Odometry`, unless it is known.

        Raises:
            UnknownDefinitionError: It is neither built in nor installed, or is malformed.
        """
        known = self.store.fielddefs
        try:
            if msgtype not in known:
                find = self._installed
                self.store.register(_with_parts(msgtype, lambda n: known.get(n) or find(n)))
            self.store.generate_msgdef(msgtype, ros_version=2)
            self.store.hash_rihs01(msgtype)
        except (TypesysError, KeyError) as error:
            raise UnknownDefinitionError(f'its definition is malformed: {error}') from error

    def _installed(self, msgtype: str) -> Any:
        for prefix in self._prefixes:
            path = prefix / 'share' / f'{msgtype}.msg'
            if path.is_file():
                return get_types_from_msg(path.read_text(encoding='utf-8'), msgtype)[msgtype]
        raise UnknownDefinitionError(f'no file {msgtype}.msg is installed')


def _installed_prefixes() -> list[Path]:
    """Return the folders in which ROS packages are installed: sourced ones, then Python's."""
    sourced = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [*(Path(prefix) for prefix in sourced if prefix), Path(sys.prefix)]


def _with_parts(msgtype: str, find: Callable[[str], Any]) -> dict[str, Any]:
    """Return the definitions of a type, its parts, and their parts, which a function finds."""
    found: dict[str, Any] = {}
    waiting = [msgtype]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = find(name)
            waiting += [part for _, desc in found[name][1] for part in _part_names(desc)]
    return found


def _part_names(desc: Any) -> list[str]:
    kind, detail = desc
    if kind == Nodetype.NAME:
        return [detail]
    return _part_names(detail[0]) if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else []
