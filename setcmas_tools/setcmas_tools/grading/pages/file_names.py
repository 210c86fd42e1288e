"""Names of students' files: safe on every system, and unique in a class."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

from setcmas_tools.grading.marks import Marks

_LONGEST = 80


def file_names(marks: Sequence[Marks]) -> list[str]:
    """Return a name for each submission, without an ending."""
    names: list[str] = []
    taken: set[str] = set()
    for one in marks:
        stem = _safe(f'{one.student.name} {one.student.id}')
        name, number = stem, 2
        while name.lower() in taken:
            name, number = f'{stem}_{number}', number + 1
        taken.add(name.lower())
        names.append(name)
    return names


def _safe(name: str) -> str:
    plain = unicodedata.normalize('NFKD', name).encode('ascii', 'ignore').decode()
    text = re.sub(r'[^A-Za-z0-9]+', '_', plain)
    return text.strip('_')[:_LONGEST] or 'student'
