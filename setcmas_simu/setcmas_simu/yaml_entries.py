"""Entries of a YAML file with their lines."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError, did_you_mean

_EXPONENT = re.compile(
    r'[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+'
)  # 1e-3: YAML 1.1 takes it for text

_LONGEST_SHOWN = 40


@dataclass(frozen=True)
class Entry:
    """A value in a YAML file, with its file and line.

    Attributes:
        file: The file.
        line: Its line, from 1.
        name: Its place, such as 'arena.x'.
        value: A scalar, a list of entries, or a dictionary of entries by key.
    """

    file: Path
    line: int
    name: str
    value: Any

    def error(self, message: str) -> SetcmasError:
        """Return an error with file and line of this value."""
        return SetcmasError(f'{self.file}, line {self.line}: {message}')

    def mistake(self, accepted: str) -> SetcmasError:
        """Return the error that this value is not what is accepted."""
        return self.error(f'{self.name or "this"} is {_shown(self.value)}; it must be {accepted}')

    def fields(self, accepted: Iterable[str]) -> dict[str, Entry]:
        """Return the entries of a mapping by key.

        Raises:
            SetcmasError: It is no mapping, or has a key that is not accepted.
        """
        known = list(accepted)
        if not isinstance(self.value, dict):
            raise self.mistake(f'a mapping with the keys {", ".join(known)}')
        for key, entry in self.value.items():
            if key not in known:
                raise entry.error(
                    f"there is no key '{entry.name}'; it must be one of {', '.join(known)}"
                    f'{did_you_mean(key, known)}'
                )
        return dict(self.value)

    def items(self) -> list[Entry]:
        """Return the entries of a list.

        Raises:
            SetcmasError: It is no list.
        """
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
        """Let messages about this value begin with file and line.

        Raises:
            SetcmasError: There is such a message.
        """
        try:
            yield
        except SetcmasError as error:
            text = str(error)
            raise (error if text.startswith(f'{self.file}, line') else self.error(text)) from None

    def number(self) -> float:
        """Return a finite number; `options.kinds.Number.of` returns one within bounds.

        Raises:
            SetcmasError: It is none.
        """
        value = self.plain()
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise self.mistake('a number')
        if not math.isfinite(value):
            raise self.mistake('a finite number')
        return float(value)

    def text(self) -> str:
        """Return a text, which may be empty.

        Raises:
            SetcmasError: It is none.
        """
        if not isinstance(self.value, str):
            raise self.mistake('a text')
        return self.value

    def flag(self) -> bool:
        """Return true or false.

        Raises:
            SetcmasError: It is neither.
        """
        if not isinstance(self.value, bool):
            raise self.mistake('true or false')
        return self.value


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return 'a mapping'
    if isinstance(value, list):
        text = f'[{", ".join(_shown(item.value) for item in value)}]'
        return text if len(text) <= _LONGEST_SHOWN else 'a list'
    return 'empty' if value is None else repr(value)


def read_entries(path: Path) -> Entry:
    """Return the content of a YAML file; an empty file is an empty mapping.

    Raises:
        SetcmasError: The file cannot be read, is not YAML, or has a key twice.
    """
    try:
        return entries_of(path.read_text(encoding='utf-8'), path)
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SetcmasError(f"'{path}' is not YAML: {error}") from error


def entries_of(text: str, path: Path) -> Entry:
    """Return the content of a text in YAML; an empty one is an empty mapping.

    Args:
        text: The text.
        path: The file that it is from.

    Raises:
        SetcmasError: It is not YAML, or has a key twice.
    """
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        return _entry(loader, path, node, '') if node else Entry(path, 1, '', {})
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f', line {mark.line + 1}' if mark else ''
        raise SetcmasError(f'{path}{line}: not YAML: {error.problem}') from error
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise SetcmasError(f"'{path}' is not YAML: {' '.join(str(error).split())}") from error


def _entry(loader: yaml.SafeLoader, path: Path, node: yaml.Node, name: str) -> Entry:
    line = node.start_mark.line + 1
    if isinstance(node, yaml.SequenceNode):
        items = [_entry(loader, path, item, f'{name}[{i}]') for i, item in enumerate(node.value)]
        return Entry(path, line, name, items)
    if not isinstance(node, yaml.MappingNode):
        return Entry(path, line, name, loader.construct_object(node))
    entries: dict[str, Entry] = {}
    for key_node, value_node in node.value:
        key = str(key_node.value)
        inner = f'{name}.{key}' if name else key
        line_of_key = key_node.start_mark.line + 1
        if key in entries:
            raise SetcmasError(
                f'{path}, line {line_of_key}: {inner} is there twice (first in line '
                f'{entries[key].line}); leave one out'
            )
        value = _entry(loader, path, value_node, inner).value
        entries[key] = Entry(path, line_of_key, inner, value)
    return Entry(path, line, name, entries)


def yaml_line(content: Mapping[str, Any]) -> str:
    """Return a text in YAML of one line."""
    return yaml.safe_dump(
        dict(content), sort_keys=False, allow_unicode=True, default_flow_style=True, width=math.inf
    ).strip()


def write_yaml(content: Mapping[str, Any], path: Path) -> None:
    """Write a YAML file, whole or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    text = yaml.safe_dump(
        dict(content), sort_keys=False, allow_unicode=True, default_flow_style=None
    )
    part = path.with_name(f'.{path.name}.part')
    with part.open('w', encoding='utf-8', newline='\n') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
