"""Marks in words: points, what a teacher is to know of a submission, the table of a class."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tabulate import tabulate

from setcmas_tools.grading.marks import Failure, Marks

_MOST_LIKE = 3
_LONGEST = 60


def points_text(points: float) -> str:
    """Return points with two decimals at most."""
    return f'{round(points, 2):g}'


def names_of(marks: Sequence[Marks]) -> dict[str, str]:
    """Return whose each submission of a class is."""
    return {one.submission: one.student.name for one in marks}


def remark(marks: Marks, names: Mapping[str, str]) -> str:
    """Return what went wrong, or what else is to be known of a submission; may be empty.

    Args:
        marks: Those of the submission.
        names: Whose the submissions of its class are.
    """
    told = ['not filled in yet'] if marks.unfilled else []
    failures = [marks.failure, *(one.failure for one in marks.scenarios)]
    told += [failure_line(one) for one in failures if one][:1]
    like = sorted(marks.similar, key=lambda one: -one.share)[:_MOST_LIKE]
    told += [f'{one.share:.0%} like {names.get(one.submission, one.submission)}' for one in like]
    return '; '.join(told)


def failure_line(failure: Failure) -> str:
    """Return what went wrong, and in which line of the script."""
    first = failure.message.strip().partition('\n')[0]
    if not failure.line or f'line {failure.line}' in first:
        return first
    return f'{first} ({failure.script}, line {failure.line})'


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
