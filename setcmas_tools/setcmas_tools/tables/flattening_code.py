"""The source of the functions that flatten messages of one type, put together and compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import Typestore

from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_tools.tables.cells import (
    array_writer,
    cells_of_messages,
    cells_of_strings,
    float32_text,
    quoted,
    stamp_text,
)
from setcmas_tools.tables.columns import (
    LONGEST_ARRAY,
    Fixed,
    Item,
    Nested,
    Repeated,
    Shape,
    column_names,
    count_entry,
    shapes_entry,
)

_STAMPS = ('builtin_interfaces/msg/Time', 'builtin_interfaces/msg/Duration')
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


@dataclass
class FlatteningCode:
    """The functions for one type, while their source is put together.

    An f-string with all fields of a message is several times as fast as a loop over them.
    """

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
            'messages': cells_of_messages,
            'yaw': yaw_of_quaternion,
            'count': count_entry,
            'shapes': shapes_entry,
        }
    )

    def add_fields(self, variable: str, msgtype: str, prefix: str) -> None:
        """Add cells for all fields of a message that a variable of the source holds."""
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
        """Add a cell with the heading of a quaternion that an expression gives."""
        q = self._assign(quaternion)
        self._add_cell('yaw', f',{{yaw({q}.x, {q}.y, {q}.z, {q}.w)!r}}')

    def compile(self) -> Flattener:
        """Return the compiled functions."""
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
    code = FlatteningCode(store)
    code.add_fields('message', msgtype, '')
    return code.compile()


_STAMP = Flattener((Fixed(('',)),), lambda stamp: f',{stamp_text(stamp)}', lambda _: ())
