"""Table of a graded class on the screen."""

from __future__ import annotations

from collections.abc import Sequence

from tabulate import tabulate

from setcmas_tools.grading.marks import Marks
from setcmas_tools.grading.pages.remarks import names_of, points_text, remark

_LONGEST = 60


def marks_table(marks: Sequence[Marks]) -> str:
    """Return a table of student, points and remarks, in their order."""
    names = names_of(marks)
    rows = [
        (_short(one.student.name), points_text(one.score), _short(remark(one, names)))
        for one in marks
    ]
    headers = ('student', f'points of {points_text(marks[0].max_score)}', 'remarks')
    align = ('left', 'decimal', 'left')
    return tabulate(rows, headers, tablefmt='simple', colalign=align, disable_numparse=True)


def _short(text: str) -> str:
    """Return a text in a line; control characters would reach the terminal."""
    plain = ''.join(each if each.isprintable() else ' ' for each in text)
    return plain if len(plain) <= _LONGEST else f'{plain[: _LONGEST - 1]}…'
