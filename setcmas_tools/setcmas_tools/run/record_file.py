"""YAML file of one record, such as run.yaml and study.yaml, with the number of its format."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml

from setcmas_simu.errors import SetcmasError

FORMAT = 1

Record = TypeVar('Record')


def write_record(content: Mapping[str, Any], path: Path) -> None:
    """Write a record, whole or not at all.

    Raises:
        OSError: The file cannot be written.
    """
    text = yaml.safe_dump({'format': FORMAT, **content}, sort_keys=False, allow_unicode=True)
    part = path.with_name(f'.{path.name}.part')
    with part.open('w', encoding='utf-8', newline='\n') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)


def read_record(path: Path, kind: type[Record]) -> Record | None:
    """Read a record of a kind; None if there is no such file.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = ' '.join(str(error).split())
        raise SetcmasError(f"'{path}' cannot be read: {reason}") from error
    given = content.get('format', 'none') if isinstance(content, dict) else 'none'
    if given != FORMAT:
        raise SetcmasError(f"'{path}' has format {given}; this setcmas reads format {FORMAT} only")
    import msgspec  # for files; a run in memory needs no msgspec

    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as error:
        raise SetcmasError(f"'{path}' is damaged: {error}") from error
