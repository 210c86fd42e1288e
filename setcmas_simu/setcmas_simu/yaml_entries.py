"""Entries of a YAML file with their lines."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError, file_errors, it_must_be
from setcmas_simu.limited_file import read_limited, written_whole

# Such as 1e-3, which is a text in YAML 1.1.
_EXPONENT = re.compile(r'[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+')

_LONGEST_SHOWN = 40
_LONGEST_TEXT = 200


@dataclass(frozen=True)
class Entry:
    """A value in a YAML file: its line, from 1, and its name there, such as 'arena.x'."""

    file: Path
    line: int
    name: str
    value: Any

    def error(self, message: str) -> SetcmasError:
        """Return an error with file and line of this value."""
        return SetcmasError(f'{self.file}, line {self.line}: {message}')

    def mistake(self, accepted: str, known: Iterable[str] = ()) -> SetcmasError:
        """Return the error that this value is not of the accepted form, or none of the known."""
        expected = it_must_be(accepted, self.value, known)
        return self.error(f'{self.name or "this"} is {_shown(self.value)}{expected}')

    def fields(self, accepted: Iterable[str]) -> dict[str, Entry]:
        """Return the entries of a mapping by key; raise SetcmasError for another key or value."""
        known = list(accepted)
        if not isinstance(self.value, dict):
            raise self.mistake(f'a mapping with the keys {", ".join(known)}')
        for key, entry in self.value.items():
            if key not in known:
                expected = it_must_be(f'one of {", ".join(known)}', key, known)
                raise entry.error(f"there is no key '{entry.name[:_LONGEST_TEXT]}'{expected}")
        return dict(self.value)

    def items(self) -> list[Entry]:
        """Return the entries of a list, or raise SetcmasError."""
        if not isinstance(self.value, list):
            raise self.mistake('a list')
        return list(self.value)

    def plain(self) -> Any:
        """Return the value as Python has it: scalars, lists and dictionaries."""
        if isinstance(self.value, dict):
            return {key: entry.plain() for key, entry in self.value.items()}
        if isinstance(self.value, list):
            return [item.plain() for item in self.value]
        if isinstance(self.value, str) and _EXPONENT.fullmatch(self.value):
            return float(self.value)
        return self.value

    @contextmanager
    def located(self) -> Iterator[None]:
        """Add file and line to the messages of SetcmasErrors about this value."""
        try:
            yield
        except SetcmasError as error:
            text = str(error)
            raise (error if text.startswith(f'{self.file}, line') else self.error(text)) from None

    def number(self) -> float:
        """Return a finite number, or raise SetcmasError; `Number.of` also checks bounds."""
        value = self.plain()
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise self.mistake('a number')
        if not math.isfinite(value):
            raise self.mistake('a finite number')
        return float(value)

    def text(self) -> str:
        """Return a text, which may be empty, or raise SetcmasError."""
        if isinstance(self.value, bool | int | float):
            raise self.mistake(f"a text; put it in quotes: '{self.value}'")
        if not isinstance(self.value, str):
            raise self.mistake('a text')
        return self.value

    def flag(self) -> bool:
        """Return true or false, or raise SetcmasError."""
        if not isinstance(self.value, bool):
            raise self.mistake('true or false')
        return self.value


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return 'a mapping'
    if isinstance(value, list):
        text = f'[{", ".join(_shown(item.value) for item in value)}]'
        return text if len(text) <= _LONGEST_SHOWN else 'a list'
    text = 'empty' if value is None else repr(value)
    return text if len(text) <= _LONGEST_TEXT else f'{text[:_LONGEST_TEXT]}…'


MOST_BYTES = 1_000_000
"""Largest YAML file, which takes 5 s to read."""
_MOST_ENTRIES = 200_000  # a file may repeat a part by its name, again and again
_DEEPEST = 50
_LONGEST_NUMBER = 100
_LONGEST_NAME = 500


def read_entries(path: Path) -> Entry:
    """Return the content of a YAML file, or raise SetcmasError; an empty file is a mapping."""
    with file_errors(f"'{path}' cannot be read"):
        content = read_limited(path, MOST_BYTES)
    try:
        return entries_of(content.decode('utf-8'), path)
    except UnicodeDecodeError as error:
        raise SetcmasError(f"'{path}' is not YAML: {error}") from error


def entries_of(text: str, path: Path) -> Entry:
    """Return the content of a YAML text from a file, or raise SetcmasError; see `read_entries`."""
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        return _Entries(loader, path).of(node, '') if node else Entry(path, 1, '', {})
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f', line {mark.line + 1}' if mark else ''
        raise SetcmasError(f'{path}{line}: not YAML: {error.problem}') from error
    except RecursionError:
        raise SetcmasError(f"'{path}' has {_TOO_DEEP}") from None
    except (yaml.YAMLError, ValueError) as error:
        raise SetcmasError(f"'{path}' is not YAML: {' '.join(str(error).split())}") from error


_TOO_DEEP = f'lists or mappings nested too deeply; at most {_DEEPEST} levels are read'


class _Entries:
    """Turns the nodes of a file into entries, up to the limits."""

    def __init__(self, loader: yaml.SafeLoader, path: Path) -> None:
        self._loader = loader
        self._path = path
        self._count = 0

    def of(self, node: yaml.Node, name: str, depth: int = 0) -> Entry:
        """Return the entry of a node, and those in it."""
        line = node.start_mark.line + 1
        self._count += 1
        if depth > _DEEPEST:
            raise SetcmasError(f'{self._path}, line {line}: {_TOO_DEEP}')
        if self._count > _MOST_ENTRIES:
            raise SetcmasError(f"'{self._path}' has more than {_MOST_ENTRIES:,} values")
        if isinstance(node, yaml.SequenceNode):
            items = [self.of(one, f'{name}[{i}]', depth + 1) for i, one in enumerate(node.value)]
            return Entry(self._path, line, name, items)
        if isinstance(node, yaml.MappingNode):
            return Entry(self._path, line, name, self._mapping(node, name, depth))
        entry = Entry(self._path, line, name, node.value)
        if node.tag == 'tag:yaml.org,2002:int' and len(node.value) > _LONGEST_NUMBER:
            raise entry.error(f'a number has more than {_LONGEST_NUMBER} digits')
        try:
            return replace(entry, value=self._loader.construct_object(node))
        except (ValueError, LookupError, AttributeError):  # such as !!int with a text
            raise entry.error(f"'{node.value}' does not suit its tag {node.tag}") from None

    def _mapping(self, node: yaml.MappingNode, name: str, depth: int) -> dict[str, Entry]:
        entries: dict[str, Entry] = {}
        for key_node, value_node in node.value:
            line, key = key_node.start_mark.line + 1, key_node.value
            own = Entry(self._path, line, f'{name}.{key}' if name else str(key), None)
            if not isinstance(key_node, yaml.ScalarNode):
                raise own.error('a key must be a text')
            if len(own.name) > _LONGEST_NAME:
                raise own.error(f'a key has more than {_LONGEST_NAME} letters')
            if key in entries:
                first = entries[key].line
                raise own.error(f'{own.name} appears twice (first in line {first}); remove one')
            value = self.of(value_node, own.name, depth + 1).value
            entries[key] = replace(own, value=value)
        return entries


def yaml_line(content: Mapping[str, Any]) -> str:
    """Return a mapping as one line of YAML."""
    # In ASCII: PyYAML does not read back every character that it writes.
    text = yaml.safe_dump(dict(content), sort_keys=False, default_flow_style=True, width=math.inf)
    return text.strip()


def write_yaml(content: Mapping[str, Any], path: Path) -> None:
    """Write a YAML file, whole or not at all, or raise OSError."""
    text = yaml.safe_dump(
        dict(content), sort_keys=False, allow_unicode=True, default_flow_style=None
    )
    with written_whole(path) as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
