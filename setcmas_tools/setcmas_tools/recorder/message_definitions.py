"""Definitions and hashes of message types, as a bag stores them."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore


class UnknownDefinitionError(Exception):
    """A message type whose definition this machine does not have."""


@dataclass(frozen=True)
class Definition:
    """What a bag stores about a type.

    Attributes:
        text: The definition, followed by those of all that it is made of.
        digest: The hash of both, as in RIHS01_....
    """

    text: str
    digest: str


class MessageDefinitions:
    """Finds definitions: those of ROS 2 Jazzy are built in, others are installed .msg files."""

    def __init__(self, prefixes: list[Path] | None = None) -> None:
        """Start with the built-in ones.

        Args:
            prefixes: Folders that hold `share/<package>/msg/<name>.msg`; by default those of the
                sourced ROS workspaces and of this Python environment.
        """
        self._prefixes = installed_prefixes() if prefixes is None else prefixes
        self._store = get_typestore(Stores.ROS2_JAZZY)

    def of(self, msgtype: str) -> Definition:
        """Return the definition of a type such as `nav_msgs/msg/Odometry`.

        Raises:
            UnknownDefinitionError: It is neither built in nor installed, or is malformed.
        """
        try:
            self._store.register(self._missing(msgtype))
            text, _ = self._store.generate_msgdef(msgtype, ros_version=2)
            return Definition(text, self._store.hash_rihs01(msgtype))
        except (TypesysError, KeyError) as error:
            raise UnknownDefinitionError(f'its definition is malformed: {error}') from error

    def _missing(self, msgtype: str) -> dict[str, Any]:
        """Return the parsed definitions of a type and its parts that are not built in."""
        found: dict[str, Any] = {}
        waiting = [msgtype]
        while waiting:
            name = waiting.pop()
            if name not in found and name not in self._store.fielddefs:
                found |= get_types_from_msg(self._text(name), name)
                waiting += [part for _, desc in found[name][1] for part in _parts(desc)]
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


def _parts(desc: Any) -> list[str]:
    kind, detail = desc
    if kind == Nodetype.NAME:
        return [detail]
    return _parts(detail[0]) if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE) else []
