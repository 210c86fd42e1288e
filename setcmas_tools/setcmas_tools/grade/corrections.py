"""Corrections of marks by hand, from corrections.yaml: points, and what each day late costs."""

from __future__ import annotations

import csv
import io
import math
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import date, datetime, timedelta
from pathlib import Path
from unicodedata import normalize

from setcmas_simu.errors import did_you_mean
from setcmas_simu.limited_file import read_limited
from setcmas_simu.option_kinds import Number
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

    def __contains__(self, text: str) -> bool:
        return _canonical(text) in self._found

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


def read_time(entry: Entry) -> datetime:
    """Return a date or a time without time zone, or raise SetcmasError."""
    value = entry.value
    if isinstance(value, str):
        value = time_of(value)
    elif type(value) is date:
        value = datetime(value.year, value.month, value.day)
    if not isinstance(value, datetime) or value.tzinfo:
        raise entry.mistake('a date such as 2026-11-20, or a time such as 2026-11-20 23:59')
    return value


_FORMATS = '%A, %d %B %Y, %I:%M %p', '%A, %B %d, %Y, %I:%M %p'  # of Moodle in English


def time_of(text: str) -> datetime | None:
    """Return a time in ISO 8601, or as Moodle writes it; None for others and with a time zone."""
    text = ' '.join(text.split())
    with suppress(ValueError):
        time = datetime.fromisoformat(text)
        return None if time.tzinfo else time
    for form in _FORMATS:
        with suppress(ValueError):
            return datetime.strptime(text, form)
    return None


_SHARE = re.compile(r'(\d+(?:\.\d+)?) ?%')


def _points_or_share(entry: Entry, rubric: Rubric) -> float:
    """Return points, which may be written as a share of the rubric's points."""
    if isinstance(entry.value, str) and (found := _SHARE.fullmatch(entry.value.strip())):
        return float(found[1]) / 100 * rubric.max_score
    if isinstance(entry.value, str):
        raise entry.mistake("points, or a share of the rubric's points such as 10 %")
    return float(_POINTS.of(entry))


@dataclass(frozen=True)
class Lateness:
    """Points taken for each day begun after a deadline, and times by submission.

    Attributes:
        signed: Who takes them, when and why, without what and points.
    """

    deadline: datetime
    per_day: float
    most: float
    submitted: Mapping[str, datetime]
    signed: Correction

    def taken(self, marks: Marks) -> tuple[str, float]:
        """Return the lateness of a submission as text, and the points that it costs."""
        time = self.submitted.get(marks.submission)
        if time is None or time <= self.deadline:
            return '', 0.0
        days = math.ceil((time - self.deadline) / timedelta(days=1))
        text = f'submitted {time:%Y-%m-%d %H:%M}, {days} day{"s" if days > 1 else ""} late'
        return text, min(days * self.per_day, self.most)


_OF_LATE = ('deadline', 'per_day', 'at_most', 'submitted', 'times', 'reason')


def _lateness(entry: Entry, known: Students, rubric: Rubric, signed: Correction) -> Lateness:
    """Return the lateness in an entry, or raise SetcmasError with file and line."""
    fields = entry.fields(_OF_LATE)
    for key in ('deadline', 'per_day'):
        if key not in fields:
            raise entry.error(f'late has no {key}; it needs deadline and per_day')
    times = _times_of_table(fields['times'], known) if 'times' in fields else {}
    given = fields.get('submitted')
    if given and not isinstance(given.value, dict):
        raise given.mistake('a mapping from students to times')
    for text, one in (given.value if given else {}).items():
        times[known.submission_of(one, text)] = read_time(one)
    reason = fields['reason'].text() if 'reason' in fields else 'late submission'
    return Lateness(
        deadline=read_time(fields['deadline']),
        per_day=_points_or_share(fields['per_day'], rubric),
        most=_points_or_share(fields['at_most'], rubric) if 'at_most' in fields else math.inf,
        submitted=times,
        signed=replace(signed, reason=reason),
    )


_WHO = ('identifier', 'email address', 'full name', 'student')
_WHEN = ('last modified (submission)', 'submitted')
"""Columns of Moodle's grading worksheet, and last those of the lecturer's own table."""


def _times_of_table(entry: Entry, known: Students) -> dict[str, datetime]:
    """Return times by submission from a table of a platform; other students are skipped."""
    path = entry.file.parent / entry.text()
    try:
        text = read_limited(path, 1 << 24).decode('utf-8-sig')
    except UnicodeError as error:
        raise entry.error(f"'{path}' is not in UTF-8; save it as CSV in UTF-8") from error
    except OSError as error:
        raise entry.error(f"'{path}' cannot be read: {error}") from error
    comma = max(',;\t', key=text.partition('\n')[0].count)
    rows = csv.DictReader(io.StringIO(text, newline=''), restval='', delimiter=comma)
    columns = rows.fieldnames = [name.strip().lower() for name in rows.fieldnames or ()]
    who = [name for name in _WHO if name in columns]
    when = [name for name in _WHEN if name in columns]
    if not who or not when:
        raise entry.error(
            f"'{path}' has no column for the student or the time; it must have one of "
            f'{", ".join(_WHO)}, and one of {", ".join(_WHEN)}'
        )
    times: dict[str, datetime] = {}
    for row in rows:
        names = (row[name].strip().removeprefix('Participant ') for name in who)
        student, time = next(filter(known.__contains__, names), ''), row[when[0]].strip()
        if student and time not in ('', '-'):
            found = time_of(time)
            if found is None:
                raise entry.error(f"'{path}' has '{time}', not a time such as 2026-11-20 23:59")
            times[known.submission_of(entry, student)] = found
    return times


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
    """The corrections of a class, checked against its students and rubric.

    Attributes:
        untimed: Submissions without a known time, if lateness counts; they count as in time.
    """

    _changes: Mapping[str, Sequence[_Change]] = field(default_factory=dict)
    _late: Lateness | None = None
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
                add(one.signed, *_as_points(one, marks))
        is_decided = changes or not marks.failure
        if self._late and is_decided and (taken := self._late.taken(marks))[1]:
            add(self._late.signed, taken[0], -taken[1])
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
    missing = [key for key in ('author', 'date') if key not in fields]
    if missing:
        raise content.error(f'{missing[0]} is missing: corrections say who decided, and when')
    author, day = fields['author'].text().strip(), f'{read_time(fields["date"]):%Y-%m-%d}'
    signed = Correction('', 0.0, '', author, day)
    known = Students(students)
    changes: dict[str, list[_Change]] = defaultdict(list)
    for item in fields['corrections'].items() if 'corrections' in fields else ():
        submission, change = _change(item, known, rubric, signed)
        of_student = changes[submission]
        same = [one for one in of_student if one.key == change.key != 'add']
        if any(one.criterion == change.criterion for one in same):
            raise item.error(f'{change.key} of the same student and criterion is set twice')
        of_student.append(change)
    if 'late' not in fields:
        return Corrections(changes)
    late = _lateness(fields['late'], known, rubric, signed)
    untimed = tuple(name for name, _ in students if name not in late.submitted)
    if marked := [name for name in untimed if '_LATE_' in name]:
        raise fields['late'].error(
            f'Canvas marks {", ".join(marked)} as late; give the time under submitted'
        )
    return Corrections(changes, late, untimed)


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
    if (key == 'points') != ('criterion' in fields) and key != 'add':
        raise fields[key].error(
            'points belong to a criterion: add criterion: NAME, or use add or total'
            if key == 'points'
            else 'a total belongs to no criterion; use points'
        )
    number = (_CHANGE if key == 'add' else _POINTS).of(fields[key])
    criterion = None
    if 'criterion' in fields:
        criterion, most = _criterion(fields['criterion'], rubric)
        if key == 'points':
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
