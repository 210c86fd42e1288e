"""Flattening of messages to rows of a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_tools.tables.cells import STAMPS, cell_of, cells_of
from setcmas_tools.tables.columns import Array, Column, Field, Lengths, Part, columns

_PLACEHOLDER = 'structure_needs_at_least_one_member'  # how an empty message is represented
_QUATERNION = 'geometry_msgs/msg/Quaternion'
_ORIENTATIONS = (
    'orientation',
    'pose.orientation',
    'pose.pose.orientation',
    'rotation',
    'transform.rotation',
)


@dataclass(frozen=True)
class Flattener:
    """Rows of messages of one type.

    Fields are joined by dots (`pose.pose.position.x`), arrays are numbered (`name[0]`), times and
    durations are one column in s with 9 decimals, booleans are 0 and 1. An array with more than
    `LONGEST_ARRAY` elements, such as an image, is one column with its length (`data.length`). A
    message with a pose, a transform or an orientation has a last column `yaw` in rad.
    """

    parts: Sequence[Part]

    def row(self, message: Any) -> tuple[list[Any], Lengths]:
        """Return the cells of a message, and the lengths of its arrays."""
        cells: list[Any] = []
        lengths: list[int] = []
        for part in self.parts:
            part.read(message, cells, lengths)
        return cells, tuple(lengths)

    def columns(self, lengths: Lengths) -> list[Column]:
        """Return the columns of messages with arrays of these lengths."""
        return list(columns(self.parts, iter(lengths)))


def flattener(store: Typestore, msgtype: str) -> Flattener:
    """Return the flattener of a type.

    Args:
        store: Holds the definitions of the type and of all that it is made of.
        msgtype: Name of the type, such as `nav_msgs/msg/Odometry`.
    """
    parts = list(_parts(store, msgtype))
    if orientation := _orientation(store, msgtype):
        parts.append(Field('yaw', _composed(attrgetter(orientation), _yaw)))
    return Flattener(parts)


def _parts(store: Typestore, msgtype: str, name: str = '', path: str = '') -> Iterator[Part]:
    for field, (kind, detail) in _fields(store, msgtype):
        field_name, field_path = f'{name}{field}', f'{path}{normalize_fieldname(field)}'
        get = attrgetter(field_path)
        if kind == Nodetype.NAME and detail not in STAMPS:
            yield from _parts(store, detail, f'{field_name}.', f'{field_path}.')
        elif kind in (Nodetype.BASE, Nodetype.NAME):
            convert = cell_of(_type_name(kind, detail))
            yield Field(field_name, _composed(get, convert) if convert else get)
        else:
            element_kind, element = detail[0]
            if element_kind == Nodetype.NAME and element not in STAMPS:
                yield Array(field_name, get, None, list(_parts(store, element)))
            else:
                yield Array(field_name, get, cells_of(_type_name(element_kind, element)))


def _fields(store: Typestore, msgtype: str) -> list[tuple[str, Any]]:
    return [field for field in store.fielddefs[msgtype][1] if field[0] != _PLACEHOLDER]


def _type_name(kind: Nodetype, detail: Any) -> str:
    name: str = detail[0] if kind == Nodetype.BASE else detail
    return name


def _composed(get: Callable[[Any], Any], convert: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda message: convert(get(message))


def _yaw(q: Any) -> float:
    yaw: float = yaw_of_quaternion(q.x, q.y, q.z, q.w)
    return yaw


def _orientation(store: Typestore, msgtype: str) -> str | None:
    for path in _ORIENTATIONS:
        found: str | None = msgtype
        for name in path.split('.'):
            fields = dict(_fields(store, found)) if found else {}
            kind, detail = fields.get(name, (None, None))
            found = detail if kind == Nodetype.NAME else None
        if found == _QUATERNION:
            return path
    return None
