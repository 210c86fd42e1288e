"""Corrections of marks by hand, from corrections.yaml: points, and what each day late costs."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import date
from functools import partial
from pathlib import Path
from unicodedata import normalize

from setcmas_simu.errors import did_you_mean
from setcmas_simu.option_kinds import Number, Whole
from setcmas_simu.yaml_entries import Entry, read_entries
from setcmas_tools.grade.criteria import rounded
from setcmas_tools.grade.mark_records import Correction, Marks
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.submissions.submitted_files import Student

Students = Sequence[tuple[str, Student]]
"""The name of each submission of a class, and its student."""

_POINTS, _CHANGE = Number(least=0, most=1e6), Number(least=-1e6, most=1e6)
_KEYS = ('author', 'date', 'late', 'corrections')
_OF_ONE = ('student', 'criterion', 'points', 'add', 'total', 'reason')
_OF_LATE = ('per_day', 'at_most', 'days', 'reason')
_ORDER = {'points': 0, 'add': 0, 'late': 1, 'total': 2}


@dataclass(frozen=True)
class Change:
    """A change of the marks of a submission.

    Attributes:
        submission: Its name.
        key: points of a criterion, or for the whole score: add, late or total.
        correction: The points that are added; for `points` and `total`, the new points.
        criterion: The names of a scenario and its criterion; None for the score.
    """

    submission: str
    key: str
    correction: Correction
    criterion: tuple[str, str] | None = None


def corrected(marks: Marks, changes: Sequence[Change]) -> Marks:
    """Return corrected marks: single points first, then lateness, and totals."""
    own = [one for one in changes if one.submission == marks.submission]
    if marks.failure and all(one.key == 'late' for one in own):
        return marks  # without a grade, there is nothing to lose
    points = {
        (scenario.name, mark.name): mark.points
        for scenario in marks.scenarios
        for mark in scenario.criteria
    }
    corrections: list[Correction] = []
    score = marks.automatic
    for one in sorted(own, key=lambda one: _ORDER[one.key]):
        added = one.correction.points
        if one.key == 'total':
            added -= score
        elif one.criterion:
            added -= points[one.criterion]
        added = rounded(max(added, -score))  # no score is below 0
        score += added
        corrections.append(replace(one.correction, points=added))
    return replace(marks, corrections=tuple(corrections))


def read_corrections(path: Path, students: Students, rubric: Rubric) -> list[Change]:
    """Read the corrections of a class.

    Raises:
        SetcmasError: The file is invalid, or a student or criterion unknown; the message has
            file and line.
    """
    content = read_entries(path)
    fields = content.fields(_KEYS)
    missing = [key for key in ('author', 'date') if key not in fields]
    if missing:
        raise content.error(f'{missing[0]} is missing: corrections say who decided, and when')
    author, day = fields['author'].text().strip(), fields['date'].value
    if type(day) is not date:
        raise fields['date'].mistake('a date such as 2026-11-20')
    sign = partial(Correction, author=author, date=str(day))
    changes: list[Change] = []
    for item in fields['corrections'].items() if 'corrections' in fields else ():
        change = _change(item, students, rubric, sign)
        of_one = [one for one in changes if one.submission == change.submission]
        same = [one for one in of_one if one.key == change.key != 'add']
        if any(one.criterion == change.criterion for one in same):
            raise item.error(f'{change.key} of the same student and criterion is set twice')
        changes.append(change)
    late = _late(fields['late'], students, sign) if 'late' in fields else ()
    return [*changes, *{one.submission: one for one in late}.values()]


def _change(item: Entry, students: Students, rubric: Rubric, sign: partial[Correction]) -> Change:
    fields = item.fields(_OF_ONE)
    if 'student' not in fields or 'reason' not in fields:
        raise item.mistake('a correction with a student and a reason')
    submission = _submission(fields['student'], str(fields['student'].plain()), students)
    given = [key for key in ('points', 'add', 'total') if key in fields]
    if len(given) != 1:
        raise item.mistake('a correction with exactly one of points, add and total')
    [key] = given
    if (key == 'points') != ('criterion' in fields):
        raise fields[key].error(
            'points belong to a criterion: add criterion: NAME, or use add or total'
            if key == 'points'
            else f'{key} belongs to no criterion; use points'
        )
    number = (_CHANGE if key == 'add' else _POINTS).of(fields[key])
    reason = ' '.join(fields['reason'].text().split())
    criterion, hidden = None, False
    if key == 'points':
        criterion, most, hidden = _criterion(fields['criterion'], rubric)
        Number(least=0, most=most).of(fields[key])
        what = ': '.join(criterion)
    elif key == 'add':
        what = 'bonus' if number >= 0 else 'deduction'
    else:
        what = f'total {number:g}'
    return Change(submission, key, sign(what, number, reason, hidden=hidden), criterion)


def _submission(entry: Entry, text: str, students: Students) -> str:
    """Return the submission of a student by name, number, email or file.

    Raises:
        SetcmasError: None or several fit.
    """
    known: dict[str, set[str]] = defaultdict(set)
    for submission, student in students:
        for key in filter(None, (student.name, student.id, student.email, submission)):
            known[key].add(submission)
    fitting = [known[key] for key in known if _canonical(key) == _canonical(text)]
    found = sorted(set().union(*fitting))
    if not found:
        near = did_you_mean(text, reversed(known))
        raise entry.error(f"there is no student '{text}' in this class{near}")
    if len(found) > 1:
        raise entry.error(
            f"{len(found)} submissions are of '{text}'; name one: {', '.join(found)}"
        )
    return found[0]


def _canonical(name: str) -> str:
    """Return what all spellings of a name have in common: capitals, spaces and accents."""
    return ' '.join(normalize('NFC', name).casefold().split())


def _criterion(entry: Entry, rubric: Rubric) -> tuple[tuple[str, str], float, bool]:
    """Return the names of a scenario and its criterion, its points, and whether it is hidden."""
    text, by_name = entry.text(), defaultdict(list)
    for scenario in rubric.scenarios:
        for one in scenario.criteria:
            names = scenario.name, one.name
            for name in {one.name, ': '.join(names)}:
                by_name[name].append((names, one.points, scenario.hidden or one.hidden))
    found = by_name.get(text, [])
    if not found:
        raise entry.error(f"there is no criterion '{text}'{did_you_mean(text, by_name)}")
    if len(found) > 1:
        names_of_all = ' or '.join(f"'{': '.join(names)}'" for names, *_ in found)
        raise entry.error(f"several criteria are named '{text}'; write {names_of_all}")
    return found[0]


def _late(entry: Entry, students: Students, sign: partial[Correction]) -> Iterator[Change]:
    """Yield what late submissions lose."""
    fields = entry.fields(_OF_LATE)
    for key in ('per_day', 'days'):
        if key not in fields:
            raise entry.error(f'late has no {key}; it needs per_day and days')
    if not isinstance(fields['days'].value, dict):
        raise fields['days'].mistake('a mapping from students to days')
    per_day = _POINTS.of(fields['per_day'])
    most = _POINTS.of(fields['at_most']) if 'at_most' in fields else math.inf
    reason = fields['reason'].text() if 'reason' in fields else 'late submission'
    for student, one in fields['days'].value.items():
        submission, days = _submission(one, student, students), Whole(0).of(one)
        if lost := min(days * per_day, most):
            what = f'{days} day{"" if days == 1 else "s"} late'
            yield Change(submission, 'late', sign(what, -lost, reason))
