"""Corrections of marks by hand, from corrections.yaml: points and lateness."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.options.kinds import Number
from setcmas_simu.yaml_entries import Entry, read_entries
from setcmas_tools.grade.criteria import rounded
from setcmas_tools.grade.lateness import (
    LATE_KEYS,
    Lateness,
    Students,
    read_lateness,
    read_time,
    untimed,
)
from setcmas_tools.grade.marks import Correction, Marks, Student
from setcmas_tools.grade.rubric import Rubric

CORRECTIONS = 'corrections.yaml'
"""Name of the file in the folder of a class, or of its grades."""

_SIGNED = ('reason', 'author', 'date')
_KEYS = ('author', 'date', 'late', 'corrections')
_OF_ONE = ('student', 'criterion', 'points', 'add', 'total', *_SIGNED)
_POINTS = Number(least=0, most=1e6)
_CHANGE = Number(least=-1e6, most=1e6)


def find_corrections(given: Path | None, submissions: Path, grades: Path) -> Path | None:
    """Return the file of corrections: as given, or in the folder of the class or its grades.

    Raises:
        SetcmasError: Both folders have one.
    """
    of_class = submissions if submissions.is_dir() else submissions.parent
    places = dict.fromkeys(folder.resolve() for folder in (of_class, grades))
    found = [folder / CORRECTIONS for folder in places if (folder / CORRECTIONS).is_file()]
    if given or not found:
        return given
    if len(found) > 1:
        raise SetcmasError(
            f"there are two files of corrections, '{found[0]}' and '{found[1]}'; name one with "
            '--corrections'
        )
    return found[0]


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
    """The corrections of a class, checked against its students and rubric.

    Attributes:
        untimed: Submissions without a known time, if lateness counts; they count as in time.
    """

    _changes: Mapping[str, Sequence[_Change]] = field(default_factory=dict)
    _late: tuple[Correction, Lateness] | None = None
    untimed: tuple[str, ...] = ()

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
                add(one.signed, *_of_criterion(one, marks))
        is_decided = changes or not marks.failure
        if self._late and is_decided and (taken := self._late[1].taken(marks))[1]:
            add(self._late[0], taken[0], -taken[1])
        for one in changes:
            if one.key == 'total':
                add(one.signed, f'total {one.number:g}', one.number - score)
        return replace(marks, corrections=tuple(corrections))


def _of_criterion(change: _Change, marks: Marks) -> tuple[str, float, bool]:
    """Return what a change is about, its points, and whether students may not see that."""
    if change.criterion is None:
        return 'bonus' if change.number >= 0 else 'deduction', change.number, False
    for scenario in marks.scenarios:
        for mark in scenario.criteria:
            if (scenario.name, mark.name) == change.criterion:
                given = mark.points if change.key == 'points' else 0.0
                hidden = scenario.hidden or mark.hidden
                return f'{scenario.name}: {mark.name}', change.number - given, hidden
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
    known = Students(students)
    common = {key: one for key, one in fields.items() if key in ('author', 'date')}
    changes: dict[str, list[_Change]] = defaultdict(list)
    for item in fields['corrections'].items() if 'corrections' in fields else ():
        submission, change = _change(item, known, rubric, common)
        of_student = changes[submission]
        same = [one for one in of_student if one.key == change.key != 'add']
        if any(one.criterion == change.criterion for one in same):
            raise item.error(f'{change.key} of the same student and criterion is set twice')
        of_student.append(change)
    if 'late' not in fields:
        return Corrections(changes)
    entry = fields['late']
    own = entry.fields((*LATE_KEYS, *_SIGNED))
    signed, late = _signed(entry, own, common, 'late submission'), read_lateness(entry, own, known)
    return Corrections(changes, (signed, late), untimed(entry, late, students))


def _change(
    item: Entry, known: Students, rubric: Rubric, common: Mapping[str, Entry]
) -> tuple[str, _Change]:
    fields = item.fields(_OF_ONE)
    if 'student' not in fields:
        raise item.mistake('a correction with a student')
    submission = known.submission_of(fields['student'], str(fields['student'].plain()))
    given = [key for key in ('points', 'add', 'total') if key in fields]
    if len(given) != 1:
        raise item.mistake('a correction with exactly one of points, add and total')
    [key] = given
    if (key == 'points') != ('criterion' in fields) and key != 'add':
        raise fields[key].error(
            'points are those of a criterion: add criterion: NAME, or use add or total'
            if key == 'points'
            else 'a total is not that of a criterion; use points'
        )
    number = (_CHANGE if key == 'add' else _POINTS).of(fields[key])
    criterion = None
    if 'criterion' in fields:
        criterion, most = _criterion(fields['criterion'], rubric)
        if key == 'points':
            Number(least=0, most=most).of(fields[key])
    return submission, _Change(key, number, criterion, _signed(item, fields, common))


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


def _signed(
    item: Entry, fields: Mapping[str, Entry], common: Mapping[str, Entry], reason: str = ''
) -> Correction:
    """Return who, when and why; author and date may be those of the whole file."""
    known = {**common, **fields}
    missing = [key for key in _SIGNED if key not in known and not (key == 'reason' and reason)]
    if missing:
        raise item.error(f'{missing[0]} is missing: a correction says who, when and why')
    if 'reason' in known:
        reason = ' '.join(known['reason'].text().split())
    author = known['author'].text().strip()
    for key, text in (('reason', reason), ('author', author)):
        if not text:
            raise known[key].mistake('a text that is not empty')
    return Correction('', 0.0, reason, author, f'{read_time(known["date"]):%Y-%m-%d}')
