"""Entries of a YAML file with their lines."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError

_EXPONENT = re.compile(
    r'[-+]?[0-9]+(\.[0-9]*)?[eE][-+]?[0-9]+'
)  # 1e-3: YAML 1.1 takes it for text

_LONGEST_SHOWN = 40


@dataclass(frozen=True)
class Entry:
    """A value in a YAML file, which knows where it stands.

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
        """Return an error that tells file and line of this value."""
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
                near = difflib.get_close_matches(str(key), known, n=1)
                hint = f'; did you mean {near[0]}?' if near else ''
                raise entry.error(
                    f"there is no key '{entry.name}'; it must be one of {', '.join(known)}{hint}"
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

    def number(
        self, least: float = -math.inf, above: float = -math.inf, most: float = math.inf
    ) -> float:
        """Return a finite number from `least`, above `above`, up to `most`.

        Raises:
            SetcmasError: It is none.
        """
        value = self.value
        if isinstance(value, str) and _EXPONENT.fullmatch(value):
            value = float(value)
        numeric = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not numeric or not math.isfinite(value) or not least <= value <= most or value <= above:
            bound = f' above {above:g}' if above > -math.inf else ''
            bound = f' from {least:g}' if least > -math.inf else bound
            bound += f' up to {most:g}' if most < math.inf else ''
            raise self.mistake(f'a number{bound}')
        return float(value)

    def whole(self, least: int) -> int:
        """Return a whole number from `least`.

        Raises:
            SetcmasError: It is none.
        """
        if isinstance(self.value, bool) or not isinstance(self.value, int) or self.value < least:
            raise self.mistake(f'a whole number from {least}')
        return self.value

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

    def choice(self, accepted: Iterable[str]) -> str:
        """Return one of some words.

        Raises:
            SetcmasError: It is none of them.
        """
        words = list(accepted)
        if self.value not in words:
            near = difflib.get_close_matches(str(self.value), words, n=1)
            raise self.mistake(
                'one of ' + ', '.join(words) + (f'; did you mean {near[0]}?' if near else '')
            )
        return str(self.value)


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
        loader = yaml.SafeLoader(path.read_text(encoding='utf-8'))
        node = loader.get_single_node()
        return _entry(loader, path, node, '') if node else Entry(path, 1, '', {})
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be read: {error.strerror}") from error
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f', line {mark.line + 1}' if mark else ''
        raise SetcmasError(f'{path}{line}: not YAML: {error.problem}') from error
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError, ValueError) as error:
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
