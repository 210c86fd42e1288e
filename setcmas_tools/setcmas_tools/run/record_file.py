"""YAML file of one record, such as run.yaml and study.yaml, with the number of its format."""

from __future__ import annotations

import dataclasses
import enum
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from setcmas_simu.errors import SetcmasError
from setcmas_simu.options.option import plain
from setcmas_simu.yaml_entries import Entry, read_entries, write_yaml

FORMAT = 1

Record = TypeVar('Record')
_NAMES = {str: 'a text', int: 'a whole number', float: 'a number', bool: 'true or false'}


def write_record(record: Any, path: Path) -> None:
    """Write a dataclass, whole or not at all; what is None is left out.

    Raises:
        OSError: The file cannot be written.
    """
    write_yaml({'format': FORMAT, **builtins_of(record)}, path)


def read_record(path: Path, kind: type[Record]) -> Record | None:
    """Read a record of a kind; None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    if not path.exists():
        return None
    content = read_entries(path)
    values = dict(content.value) if isinstance(content.value, dict) else {}
    found = values.pop('format').value if 'format' in values else 'none'
    if found != FORMAT:
        raise SetcmasError(f"'{path}' has format {found}; this setcmas reads format {FORMAT} only")
    record: Record = _converted(dataclasses.replace(content, value=values), kind)
    return record


def builtins_of(value: Any) -> Any:
    """Return a record as YAML has it, without what is None in dataclasses."""
    if dataclasses.is_dataclass(value):
        pairs = ((one.name, getattr(value, one.name)) for one in dataclasses.fields(value))
        return {name: builtins_of(one) for name, one in pairs if one is not None}
    if isinstance(value, enum.Enum):
        return value.value
    if isinstance(value, Mapping):
        return {key: builtins_of(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [builtins_of(one) for one in value]
    return plain(value)


def _converted(entry: Entry, kind: Any) -> Any:
    """Return the value of an entry as a type has it.

    Raises:
        SetcmasError: It is of another type; the message names file and line.
    """
    inner = typing.get_args(kind)
    if kind is Any:
        return entry.plain()
    if isinstance(kind, types.UnionType):
        others = [one for one in inner if one is not type(None)]
        return None if entry.value is None else _converted(entry, others[0])
    if dataclasses.is_dataclass(kind):
        return _record(entry, kind)
    if typing.get_origin(kind) is list:
        return [_converted(item, inner[0]) for item in entry.items()]
    if typing.get_origin(kind) is dict:
        if not isinstance(entry.value, dict):
            raise entry.mistake('a mapping')
        return {key: _converted(one, inner[1]) for key, one in entry.value.items()}
    if issubclass(kind, enum.Enum):
        return kind(entry.choice([one.value for one in kind]))
    accepted = (int, float) if kind is float else kind
    if not isinstance(entry.value, accepted) or (kind is not bool and entry.value is True):
        raise entry.mistake(_NAMES[kind])
    return entry.value


def _record(entry: Entry, kind: Any) -> Any:
    hints = typing.get_type_hints(kind)
    given = entry.fields(hints)
    values = {name: _converted(one, hints[name]) for name, one in given.items()}
    for one in dataclasses.fields(kind):
        has_default = one.default is not one.default_factory  # both are MISSING without one
        if one.name not in values and not has_default:
            if type(None) not in typing.get_args(hints[one.name]):
                raise entry.error(f'{one.name} is missing')
            values[one.name] = None
    return kind(**values)
