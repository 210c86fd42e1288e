"""Flattening of messages to CSV cells, by functions that are compiled once for each type."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore
from setcmas_simu.planar_pose import yaw_of_quaternion

from setcmas_tools.cell_text import (
    LONGEST_ARRAY,
    array_writer,
    cells_of_strings,
    float32_text,
    quoted,
    stamp_text,
)
from setcmas_tools.column_shape import Fixed, Item, Nested, Repeated, Shape, column_names

_STAMPS = ('builtin_interfaces/msg/Time', 'builtin_interfaces/msg/Duration')
_QUATERNION = 'geometry_msgs/msg/Quaternion'
_ORIENTATIONS = ('orientation', 'pose.orientation', 'pose.pose.orientation') + (
    'rotation',
    'transform.rotation',
)
_PLACEHOLDER = 'structure_needs_at_least_one_member'  # how an empty message is represented
_CELLS = {
    'bool': ',{{{}:d}}',
    'float32': ',{{float32({})}}',
    'float64': ',{{{}!r}}',
    'string': ',{{quoted({})}}',
    'wstring': ',{{quoted({})}}',
}


@dataclass(frozen=True)
class Flattener:
    """How messages of a type become rows.

    Fields are joined by dots (`pose.pose.position.x`), arrays are numbered (`name[0]`), times and
    durations are one column in s with 9 decimals, booleans are 0 and 1. An array with more than
    `cell_text.LONGEST_ARRAY` elements is one column with its length (`data.length`). A message
    that holds a pose, or a transform, has a last column `yaw` in rad.

    Attributes:
        items: The columns.
        cells: Makes the text of the row of a message, with a comma before each cell.
        shape: Returns the lengths of the arrays of a message, on which its columns depend.
    """

    items: tuple[Item, ...]
    cells: Callable[[Any], str]
    shape: Callable[[Any], Shape]

    @property
    def has_fixed_columns(self) -> bool:
        """Whether all messages of the type have the same columns."""
        return all(isinstance(item, Fixed) for item in self.items)

    def columns(self, shape: Shape = ()) -> list[str]:
        """Return the names of the columns of messages of a shape."""
        return list(column_names(self.items, shape))


def flattener(store: Typestore, msgtype: str) -> Flattener:
    """Compile the flattener of a type.

    Args:
        store: Holds the definitions of the type and of all that it is made of.
        msgtype: Name of the type, such as `nav_msgs/msg/Odometry`.
    """
    code = _Code(store)
    code.add_fields('message', msgtype, '')
    if orientation := _orientation(store, msgtype):
        code.add_yaw(f'message.{orientation}')
    return code.compile()


def _orientation(store: Typestore, msgtype: str) -> str | None:
    for path in _ORIENTATIONS:
        found: str | None = msgtype
        for name in path.split('.'):
            fields = dict(store.fielddefs[found][1]) if found else {}
            kind, detail = fields.get(name, (None, None))
            found = detail if kind == Nodetype.NAME else None
        if found == _QUATERNION:
            return path
    return None


@dataclass
class _Code:
    """The source of the functions for one type, while it is put together."""

    store: Typestore
    assignments: list[str] = field(default_factory=list)
    text: list[str] = field(default_factory=list)
    shape: list[str] = field(default_factory=list)
    items: list[Item] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    namespace: dict[str, Any] = field(
        default_factory=lambda: {
            'float32': float32_text,
            'quoted': quoted,
            'stamp': stamp_text,
            'strings': cells_of_strings,
            'messages': _cells_of_messages,
            'yaw': yaw_of_quaternion,
            'count': _count,
            'shapes': _shapes,
        }
    )

    def add_fields(self, variable: str, msgtype: str, prefix: str) -> None:
        for name, (kind, detail) in self.store.fielddefs[msgtype][1]:
            if name == _PLACEHOLDER:
                continue
            access = f'{variable}.{normalize_fieldname(name)}'
            if kind == Nodetype.BASE:
                self._add_cell(prefix + name, _CELLS.get(detail[0], ',{{{}}}').format(access))
            elif kind == Nodetype.NAME and detail in _STAMPS:
                self._add_cell(prefix + name, f',{{stamp({access})}}')
            elif kind == Nodetype.NAME:
                inner = self._assign(access)
                self.add_fields(inner, detail, f'{prefix}{name}.')
            elif detail[0][0] == Nodetype.BASE:
                self._add_values(access, detail, prefix + name, kind == Nodetype.ARRAY)
            else:
                self._add_messages(access, detail[0][1], prefix + name)

    def add_yaw(self, quaternion: str) -> None:
        q = self._assign(quaternion)
        self._add_cell('yaw', f',{{yaw({q}.x, {q}.y, {q}.z, {q}.w)!r}}')

    def compile(self) -> Flattener:
        self._end_fixed()
        assignments = [f' {line}\n' for line in self.assignments]
        source = [
            f'def cells(message):\n{"".join(assignments)} return f"{"".join(self.text)}"\n',
            f'def shape(message):\n{"".join(assignments)} return ({"".join(self.shape)})\n',
        ]
        exec(compile(''.join(source), '<flattening>', 'exec'), self.namespace)
        return Flattener(tuple(self.items), self.namespace['cells'], self.namespace['shape'])

    def _assign(self, expression: str) -> str:
        variable = f'v{len(self.assignments)}'
        self.assignments.append(f'{variable} = {expression}')
        return variable

    def _bind(self, value: Any) -> str:
        name = f'f{len(self.namespace)}'
        self.namespace[name] = value
        return name

    def _add_cell(self, name: str, text: str) -> None:
        self.names.append(name)
        self.text.append(text)

    def _end_fixed(self) -> None:
        if self.names:
            self.items.append(Fixed(tuple(self.names)))
            self.names.clear()

    def _add_values(self, access: str, detail: Any, name: str, is_fixed: bool) -> None:
        (_, (base, _)), length = detail
        function = 'strings' if 'string' in base else self._bind(array_writer())
        self.text.append(f'{{{function}({access})}}')
        if is_fixed and length <= LONGEST_ARRAY:
            self.names.extend(f'{name}[{i}]' for i in range(length))
        elif is_fixed:
            self.names.append(f'{name}.length')
        else:
            self._end_fixed()
            self.items.append(Repeated(name, ('',)))
            self.shape.append(f'count({access}),')

    def _add_messages(self, access: str, msgtype: str, name: str) -> None:
        element = _STAMP if msgtype in _STAMPS else _element(self.store, msgtype)
        self.text.append(f'{{messages({access}, {self._bind(element.cells)})}}')
        self._end_fixed()
        if element.has_fixed_columns:
            parts = (f'.{column}' if column else '' for column in element.columns())
            self.items.append(Repeated(name, tuple(parts)))
            self.shape.append(f'count({access}),')
        else:
            self.items.append(Nested(name, element.items))
            self.shape.append(f'shapes({access}, {self._bind(element.shape)}),')


def _element(store: Typestore, msgtype: str) -> Flattener:
    code = _Code(store)
    code.add_fields('message', msgtype, '')
    return code.compile()


_STAMP = Flattener((Fixed(('',)),), lambda stamp: f',{stamp_text(stamp)}', lambda _: ())


def _cells_of_messages(messages: list[Any], cells: Callable[[Any], str]) -> str:
    if len(messages) > LONGEST_ARRAY:
        return f',{len(messages)}'
    return ''.join([cells(message) for message in messages])


def _count(array: Any) -> tuple[int, bool]:
    length = len(array)
    return (0, True) if length > LONGEST_ARRAY else (length, False)


def _shapes(messages: list[Any], shape: Callable[[Any], Shape]) -> tuple[tuple[Shape, ...], bool]:
    if len(messages) > LONGEST_ARRAY:
        return (), True
    return tuple([shape(message) for message in messages]), False
