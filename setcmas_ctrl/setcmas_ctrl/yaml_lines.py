"""YAML files whose mistakes are told with their line."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import yaml

from setcmas_simu.errors import SetcmasError


@dataclass(frozen=True)
class Entry:
    """A part of a YAML file.

    Attributes:
        node: What the parser read.
        file: What to call the file in messages.
    """

    node: yaml.Node
    file: str

    def error(self, message: str) -> SetcmasError:
        """Return an error that tells file and line of this entry."""
        return SetcmasError(f'{self.file}, line {self.node.start_mark.line + 1}: {message}')

    def mapping(self, accepted: tuple[str, ...]) -> dict[str, Entry]:
        """Return the values by key.

        Raises:
            SetcmasError: It is no mapping, has a key that is not accepted, or one twice.
        """
        if not isinstance(self.node, yaml.MappingNode):
            raise self.error(f'accepted are the keys {", ".join(accepted)}')
        values: dict[str, Entry] = {}
        for key_node, value in self.node.value:
            key = Entry(key_node, self.file)
            name = key.text()
            if name not in accepted:
                raise key.error(f"'{name}' is unknown; accepted are {', '.join(accepted)}")
            if name in values:
                raise key.error(f"'{name}' is there twice")
            values[name] = Entry(value, self.file)
        return values

    def single_pair(self, accepted: str) -> tuple[Entry, Entry]:
        """Return key and value of a mapping with one of each.

        Raises:
            SetcmasError: It is something else.
        """
        if not isinstance(self.node, yaml.MappingNode) or len(self.node.value) != 1:
            raise self.error(f'accepted are {accepted}')
        key, value = self.node.value[0]
        return Entry(key, self.file), Entry(value, self.file)

    def items(self) -> list[Entry]:
        """Return the items of a list.

        Raises:
            SetcmasError: It is no list, or an empty one.
        """
        if not isinstance(self.node, yaml.SequenceNode) or not self.node.value:
            raise self.error('accepted is a list that is not empty')
        return [Entry(item, self.file) for item in self.node.value]

    def text(self) -> str:
        """Return a single value as it was written.

        Raises:
            SetcmasError: It is a list or a mapping.
        """
        if not isinstance(self.node, yaml.ScalarNode):
            raise self.error('accepted is a single value')
        return str(self.node.value)

    def number(self, accepted: str, least: float = 0.0, most: float = math.inf) -> float:
        """Return a finite number within bounds.

        Args:
            accepted: What to call such a number.
            least: Lower bound.
            most: Upper bound.

        Raises:
            SetcmasError: It is something else.
        """
        text = self.text()
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (least <= value <= most and math.isfinite(value)):
            raise self.error(f"'{text}' is not {accepted}")
        return value

    def boolean(self) -> bool:
        """Return true or false.

        Raises:
            SetcmasError: It is something else.
        """
        text = self.text()
        if text not in ('true', 'false'):
            raise self.error(f"'{text}' is neither true nor false")
        return text == 'true'


def read_yaml(path: Path, kind: str) -> Entry:
    """Return the content of a file.

    Args:
        path: The file.
        kind: What to call such a file in messages.

    Raises:
        SetcmasError: It cannot be read, is not YAML, or is empty.
    """
    file = f"{kind} '{path}'"
    try:
        node = yaml.compose(path.read_text(encoding='utf-8'), Loader=yaml.SafeLoader)
    except OSError as error:
        raise SetcmasError(f'{file} cannot be read: {error.strerror}') from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = ' '.join(str(error).split())
        raise SetcmasError(f'{file} is not valid YAML: {reason}') from error
    if node is None:
        raise SetcmasError(f'{file} is empty')
    return Entry(node, file)
