"""Corrections of marks by hand, from corrections.yaml: points, and what each day late costs."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path
from unicodedata import normalize

from setcmas_simu.errors import did_you_mean
from setcmas_simu.option_kinds import Number, Whole
from setcmas_simu.yaml_entries import Entry, read_entries
from setcmas_tools.grade.criteria import rounded
from setcmas_tools.grade.mark_records import Correction, Marks
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.submissions.submitted_files import Student

_POINTS = Number(least=0, most=1e6)


class Students:
    """The submissions of a class, by what identifies their students."""

    def __init__(self, students: Iterable[tuple[str, Student]]) -> None:
        """Take the name of each submission, and its student."""
        self._found: dict[str, set[str]] = defaultdict(set)
        self._names: dict[str, None] = {}
        for submission, student in students:
            for key in filter(None, (student.name, student.id, student.email, submission)):
                self._names[key] = None
                self._found[_canonical(key)].add(submission)

    def submission_of(self, entry: Entry, text: str) -> str:
        """Return the submission of a student by name, number, email or file.

        Raises:
            SetcmasError: None or several fit.
        """
        found = sorted(self._found.get(_canonical(text), ()))
        if not found:
            near = did_you_mean(text, reversed(self._names))
            raise entry.error(f"there is no student '{text}' in this class{near}")
        if len(found) > 1:
            raise entry.error(
                f"{len(found)} submissions are of '{text}'; name one: {', '.join(found)}"
            )
        return found[0]


def _canonical(name: str) -> str:
    """Return what all spellings of a name have in common: capitals, spaces and accents."""
    return ' '.join(normalize('NFC', name).casefold().split())


_OF_LATE = ('per_day', 'at_most', 'days', 'reason')


def _late(entry: Entry, known: Students, signed: Correction) -> dict[str, Correction]:
    """Return what late submissions lose, by submission; `signed` says who decided, and when."""
    fields = entry.fields(_OF_LATE)
    for key in ('per_day', 'days'):
        if key not in fields:
            raise entry.error(f'late has no {key}; it needs per_day and days')
    if not isinstance(fields['days'].value, dict):
        raise fields['days'].mistake('a mapping from students to days')
    per_day = _POINTS.of(fields['per_day'])
    most = _POINTS.of(fields['at_most']) if 'at_most' in fields else math.inf
    reason = fields['reason'].text() if 'reason' in fields else 'late submission'
    late: dict[str, Correction] = {}
    for student, one in fields['days'].value.items():
        days = Whole(0).of(one)
        lost = min(days * per_day, most)
        text = f'{days} day{"" if days == 1 else "s"} late'
        late[known.submission_of(one, student)] = replace(
            signed, what=text, points=-lost, reason=reason
        )
    return late


_KEYS = ('author', 'date', 'late', 'corrections')
_OF_ONE = ('student', 'criterion', 'points', 'add', 'total', 'reason')
_CHANGE = Number(least=-1e6, most=1e6)


@dataclass(frozen=True)
class _Change:
    """A correction of one student's marks; without a criterion, of the score.

    Attributes:
        key: The key of its number: points, add or total.
        signed: Who corrected, when and why, without what and points.
    """

    key: str
    number: float
    criterion: tuple[str, str] | None
    signed: Correction


@dataclass(frozen=True)
class Corrections:
    """The corrections of a class, checked against its students and rubric."""

    _changes: Mapping[str, Sequence[_Change]] = field(default_factory=dict)
    _late: Mapping[str, Correction] = field(default_factory=dict)

    def applied(self, marks: Marks) -> Marks:
        """Return corrected marks: single points first, then lateness, and totals."""
        corrections: list[Correction] = []
        score = marks.automatic

        def add(signed: Correction, what: str, points: float, hidden: bool = False) -> None:
            nonlocal score
            points = rounded(max(points, -score))  # no score is below 0
            score += points
            corrections.append(replace(signed, what=what, points=points, hidden=hidden))

        changes = self._changes.get(marks.submission, ())
        for one in changes:
            if one.key != 'total':
                add(one.signed, *_as_points(one, marks))
        late = self._late.get(marks.submission)
        if late and late.points and (changes or not marks.failure):
            add(late, late.what, late.points)
        for one in changes:
            if one.key == 'total':
                add(one.signed, f'total {one.number:g}', one.number - score)
        return replace(marks, corrections=tuple(corrections))


def _as_points(change: _Change, marks: Marks) -> tuple[str, float, bool]:
    """Return what a change is about, its points, and whether students may not see that."""
    if change.criterion is None:
        return 'bonus' if change.number >= 0 else 'deduction', change.number, False
    for scenario in marks.scenarios:
        for mark in scenario.criteria:
            if (scenario.name, mark.name) == change.criterion:
                hidden = scenario.hidden or mark.hidden
                return f'{scenario.name}: {mark.name}', change.number - mark.points, hidden
    raise KeyError(change.criterion)


def read_corrections(
    path: Path, students: Sequence[tuple[str, Student]], rubric: Rubric
) -> Corrections:
    """Read the corrections of a class; `students` are by the names of their submissions.

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
    signed = Correction('', 0.0, '', author, str(day))
    known = Students(students)
    changes: dict[str, list[_Change]] = defaultdict(list)
    for item in fields['corrections'].items() if 'corrections' in fields else ():
        submission, change = _change(item, known, rubric, signed)
        of_student = changes[submission]
        same = [one for one in of_student if one.key == change.key != 'add']
        if any(one.criterion == change.criterion for one in same):
            raise item.error(f'{change.key} of the same student and criterion is set twice')
        of_student.append(change)
    late = _late(fields['late'], known, signed) if 'late' in fields else {}
    return Corrections(changes, late)


def _change(
    item: Entry, known: Students, rubric: Rubric, signed: Correction
) -> tuple[str, _Change]:
    fields = item.fields(_OF_ONE)
    if 'student' not in fields or 'reason' not in fields:
        raise item.mistake('a correction with a student and a reason')
    submission = known.submission_of(fields['student'], str(fields['student'].plain()))
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
    criterion = None
    if 'criterion' in fields:
        criterion, most = _criterion(fields['criterion'], rubric)
        Number(least=0, most=most).of(fields[key])
    reason = ' '.join(fields['reason'].text().split())
    return submission, _Change(key, number, criterion, replace(signed, reason=reason))


def _criterion(entry: Entry, rubric: Rubric) -> tuple[tuple[str, str], float]:
    """Return the names of a scenario and its criterion, and the criterion's points."""
    text, by_name = entry.text(), defaultdict(list)
    for scenario in rubric.scenarios:
        for one in scenario.criteria:
            for name in {one.name, f'{scenario.name}: {one.name}'}:
                by_name[name].append(((scenario.name, one.name), one.points))
    found = by_name.get(text, [])
    if not found:
        raise entry.error(f"there is no criterion '{text}'{did_you_mean(text, by_name)}")
    if len(found) > 1:
        names = ' or '.join(f"'{scenario}: {name}'" for (scenario, name), _ in found)
        raise entry.error(f"several criteria are named '{text}'; write {names}")
    return found[0]
