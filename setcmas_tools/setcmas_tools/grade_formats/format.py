"""Formats of grades, found by name: files of a graded class, and what a platform grades with."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu.doors import Door, instance_of
from setcmas_tools.grade_formats.bundles.kit import Kit
from setcmas_tools.grading.marks import Marks
from setcmas_tools.grading.pages.file_names import file_names
from setcmas_tools.grading.student_view import student_view

Files = Mapping[str, str | bytes]
"""Contents of files by their paths, with / between folders."""


@dataclass(frozen=True)
class GradeFormat:
    """A format of grades.

    Attributes:
        purpose: What reads it, in a line.
        files: Returns the files of a graded class, of one submission or more.
        bundle: Returns what a platform needs to grade with setcmas; None if it cannot.
    """

    purpose: str
    files: Callable[[Sequence[Marks]], Files]
    bundle: Callable[[Kit], Files] | None = None


GRADE_FORMATS: Door[GradeFormat] = Door(
    'setcmas.grade_formats', 'grade format', instance_of(GradeFormat)
)
"""The formats that are installed."""

CLASS_FORMATS = ('csv', 'moodle', 'canvas', 'junit')
"""Formats that a class is written in unless others are named."""


def result_files(folder: str, result: Callable[[Marks], Mapping[str, Any]]) -> Any:
    """Return the function `files` of a format with a JSON file for each submission.

    Args:
        folder: Where they go.
        result: Returns the content for the marks of a submission, as its student may see them.
    """

    def files(marks: Sequence[Marks]) -> Files:
        contents = [_json(result(student_view(one))) for one in marks]
        names = [f'{folder}/{name}.json' for name in file_names(marks)]
        return dict(zip(names, contents, strict=True))

    return files


def _json(content: Mapping[str, Any]) -> str:
    return json.dumps(content, indent=1, ensure_ascii=False) + '\n'


def write_formats(names: Iterable[str], marks: Sequence[Marks], folder: Path) -> list[Path]:
    """Write a graded class in some formats into a folder; returns the files.

    Raises:
        SetcmasError: There is no such format.
        OSError: They cannot be written.
    """
    paths = []
    for format_ in [GRADE_FORMATS.get(name) for name in names]:
        for name, content in format_.files(marks).items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(
                content.encode(errors='replace') if isinstance(content, str) else content
            )
            paths.append(path)
    return paths
