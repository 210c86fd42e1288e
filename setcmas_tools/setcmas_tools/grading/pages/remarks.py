"""Marks in words: points as texts, and what a teacher is to know of a submission in a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from setcmas_tools.grading.marks import Failure, Marks

_MOST_LIKE = 3


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
