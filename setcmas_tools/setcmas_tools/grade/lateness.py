"""Lateness: submission times, and what each day after a deadline costs."""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from unicodedata import normalize

from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.limited_file import read_limited
from setcmas_simu.options.kinds import Number
from setcmas_simu.yaml_entries import Entry
from setcmas_tools.grade.marks import Marks, Student

_POINTS = Number(least=0, most=1e6)

LATE_KEYS = ('deadline', 'per_day', 'grace', 'at_most', 'submitted', 'times')
"""Keys of lateness in corrections.yaml."""


class Students:
    """The submissions of a class, by what identifies their students."""

    def __init__(self, students: Iterable[tuple[str, Student]]) -> None:
        """Take the name of each submission, and its student."""
        self._found: dict[str, set[str]] = defaultdict(set)
        self._names: dict[str, None] = {}
        for submission, student in students:
            for key in filter(None, (student.name, student.id, student.email, submission)):
                self._names[key] = None
                self._found[_same(key)].add(submission)

    def __contains__(self, text: str) -> bool:
        return _same(text) in self._found

    def submission_of(self, entry: Entry, text: str) -> str:
        """Return the submission of a student by name, number, email or file.

        Raises:
            SetcmasError: None or several fit.
        """
        found = sorted(self._found.get(_same(text), ()))
        if not found:
            near = did_you_mean(text, reversed(self._names))
            raise entry.error(f"there is no student '{text}' in this class{near}")
        if len(found) > 1:
            raise entry.error(
                f"{len(found)} submissions are of '{text}'; name one: {', '.join(found)}"
            )
        return found[0]


def _same(name: str) -> str:
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


_DAYS = ('%A, %d %B %Y', '%A, %B %d, %Y', '%a, %d %b %Y', '%d %B %Y', '%B %d, %Y', '%d %b %Y')
_FORMATS = (
    '%Y-%m-%d', '%Y-%m-%d %H:%M', '%Y-%m-%d %H:%M:%S', '%Y-%m-%dT%H:%M', '%Y-%m-%dT%H:%M:%S',
    '%Y-%m-%d %H:%M:%S %z',
    *(f'{day}, {clock}' for day in _DAYS for clock in ('%I:%M %p', '%H:%M', '%I:%M:%S %p')),
)  # fmt: skip


def time_of(text: str) -> datetime | None:
    """Return a time as platforms write it, as on their clock; None for another text."""
    for form in _FORMATS:
        with suppress(ValueError):
            return datetime.strptime(' '.join(text.split()), form).replace(tzinfo=None)
    return None


_SHARE = re.compile(r'(\d+(?:\.\d+)?) ?%')
_SPAN = re.compile(r'(\d+(?:\.\d+)?) ?(min|h|days?)')
_UNITS = {'min': 60, 'h': 3600, 'day': 86400, 'days': 86400}


def _points_or_share(entry: Entry) -> tuple[float, bool]:
    """Return points, or a share of the rubric's points, and whether it is a share."""
    if isinstance(entry.value, str) and (found := _SHARE.fullmatch(entry.value.strip())):
        return float(found[1]) / 100, True
    if isinstance(entry.value, str):
        raise entry.mistake("points, or a share of the rubric's points such as 10 %")
    return _POINTS.of(entry), False


def _span(entry: Entry) -> timedelta:
    found = _SPAN.fullmatch(entry.value.strip()) if isinstance(entry.value, str) else None
    if not found:
        raise entry.mistake('a time such as 15 min, 2 h or 1 day')
    return timedelta(seconds=float(found[1]) * _UNITS[found[2]])


@dataclass(frozen=True)
class Lateness:
    """Points (or a share of the rubric's points) taken for each day begun after a deadline."""

    deadline: datetime
    per_day: tuple[float, bool]
    most: tuple[float, bool]
    grace: timedelta
    submitted: Mapping[str, datetime]

    def taken(self, marks: Marks) -> tuple[str, float]:
        """Return the lateness of a submission as text, and the points that it costs."""
        time = self.submitted.get(marks.submission)
        if time is None or time <= self.deadline + self.grace:
            return '', 0.0
        days = math.ceil((time - self.deadline) / timedelta(days=1))
        per_day, most = (
            number * marks.max_score if is_share else number
            for number, is_share in (self.per_day, self.most)
        )
        text = f'submitted {time:%Y-%m-%d %H:%M}, {days} day{"s" if days > 1 else ""} late'
        return text, min(days * per_day, most)


def read_lateness(entry: Entry, fields: Mapping[str, Entry], known: Students) -> Lateness:
    """Read lateness from the fields of its entry.

    Raises:
        SetcmasError: One is invalid, or a student unknown; the message has file and line.
    """
    for key in ('deadline', 'per_day'):
        if key not in fields:
            raise entry.error(f'late has no {key}; it needs deadline and per_day')
    times = _times_of_table(fields['times'], known) if 'times' in fields else {}
    given = fields.get('submitted')
    if given and not isinstance(given.value, dict):
        raise given.mistake('a mapping from students to times')
    for text, one in (given.value if given else {}).items():
        times[known.submission_of(one, text)] = read_time(one)
    return Lateness(
        deadline=read_time(fields['deadline']),
        per_day=_points_or_share(fields['per_day']),
        most=_points_or_share(fields['at_most']) if 'at_most' in fields else (math.inf, False),
        grace=_span(fields['grace']) if 'grace' in fields else timedelta(),
        submitted=times,
    )


_UTF_16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
_WHO = ('identifier', 'id', 'sid', 'email address', 'email', 'full name', 'name', 'student')
_WHEN = ('last modified (submission)', 'submission time', 'submitted')


def _times_of_table(entry: Entry, known: Students) -> dict[str, datetime]:
    """Return times by submission from a table of a platform; other students are skipped."""
    path = entry.file.parent / entry.text()
    try:
        content = read_limited(path, 1 << 24)
        text = content.decode('utf-16' if content[:2] in _UTF_16 else 'utf-8-sig')
        comma = max(',;\t', key=text.partition('\n')[0].count)
        rows = list(csv.reader(io.StringIO(text, newline=''), delimiter=comma))
    except UnicodeError as error:
        raise entry.error(f"'{path}' is not in UTF-8; save it as CSV in UTF-8") from error
    except (OSError, csv.Error) as error:
        raise entry.error(f"'{path}' cannot be read: {error}") from error
    header = [name.strip().lower() for name in rows[0]] if rows else []
    who = [header.index(name) for name in _WHO if name in header]
    when = [header.index(name) for name in _WHEN if name in header]
    if not who or not when:
        raise entry.error(
            f"'{path}' has no column for the student or the time; it must have one of "
            f'{", ".join(_WHO)}, and one of {", ".join(_WHEN)}'
        )
    times: dict[str, datetime] = {}
    for number, row in enumerate(rows[1:], start=2):
        cells = [cell.strip().removeprefix('Participant ') for cell in row]
        texts = [cells[i] for i in who if i < len(cells) and cells[i] in known]
        time = cells[when[0]] if when[0] < len(cells) else ''
        if texts and time not in ('', '-'):
            found = time_of(time)
            if found is None:
                raise SetcmasError(
                    f"{path}, line {number}: '{time}' is not a time such as 2026-11-20 23:59"
                )
            times[known.submission_of(entry, texts[0])] = found
    return times


def untimed(
    entry: Entry, late: Lateness, students: Sequence[tuple[str, Student]]
) -> tuple[str, ...]:
    """Return submissions without a time; those that Canvas names LATE must have one."""
    unknown = tuple(name for name, _ in students if name not in late.submitted)
    if marked := [name for name in unknown if '_LATE_' in name]:
        raise entry.error(
            f'Canvas marks {", ".join(marked)} as late; give the time under submitted'
        )
    return unknown
