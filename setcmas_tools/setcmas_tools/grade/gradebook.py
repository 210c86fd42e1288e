"""Gradebook of a class: a page per student, and tables for teachers and platforms."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

from tabulate import tabulate

from setcmas_simu.errors import needs
from setcmas_tools.grade.criteria import points_text
from setcmas_tools.grade.mark_records import CriterionMark, Marks, lines_of, student_view

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


_MOST_LIKE = 3
_LONGEST_REMARK = 60


def names_of(marks: Sequence[Marks]) -> dict[str, str]:
    """Return the student of each submission."""
    return {one.submission: one.student.name for one in marks}


def remark(marks: Marks, names: Mapping[str, str]) -> str:
    """Return a remark on the mistake and on similarities; `names` are students' by submission."""
    notes = ['not filled in yet'] if marks.unfilled else []
    failures = [marks.failure, *(one.failure for one in marks.scenarios)]
    hints = [mark.hint for one in marks.scenarios for mark in one.criteria if mark.hint]
    notes += [*[one.reason for one in failures if one], *hints][:1]
    notes += map(str, marks.corrections)
    like = sorted(marks.similar, key=lambda one: -one.share)[:_MOST_LIKE]
    notes += [f'{one.share:.0%} like {names.get(one.submission, one.submission)}' for one in like]
    return '; '.join(notes)


def marks_table(marks: Sequence[Marks]) -> str:
    """Return a table of student, points and remarks, in their order."""
    names = names_of(marks)
    rows = [
        (
            _short(one.student.name),
            points_text(one.score) if one.is_decided else '',
            _short(remark(one, names)),
        )
        for one in marks
    ]
    headers = ('student', f'points of {points_text(marks[0].max_score)}', 'remarks')
    table: str = tabulate(rows, headers, colalign=('left', 'right', 'left'), disable_numparse=True)
    return table


def _short(text: str) -> str:
    """Return a text on one line, without control characters, which could affect the terminal."""
    plain = ''.join(each if each.isprintable() else ' ' for each in text)
    return plain if len(plain) <= _LONGEST_REMARK else f'{plain[: _LONGEST_REMARK - 1]}…'


_CONTROL = re.compile(r'[\x00-\x08\x0b-\x1f\x7f-\x9f]')


def pages_of(marks: Sequence[Marks]) -> dict[str, str]:
    """Return a page per submission by path, students/NAME.html: what its student may see.

    Raises:
        SetcmasError: jinja2 is missing.
    """
    with needs('grade'):
        from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

    places = [PackageLoader(__package__), PackageLoader('setcmas_tools.page')]
    environment = Environment(
        loader=ChoiceLoader(places),
        autoescape=True,  # names, messages and scripts may hold HTML
        undefined=StrictUndefined,
    )
    environment.filters['points'] = points_text
    template = environment.get_template('student.html')
    texts = (template.render(marks=student_view(one)) for one in marks)
    shown = (_CONTROL.sub('\N{REPLACEMENT CHARACTER}', text) for text in texts)
    return dict(zip((f'students/{name}.html' for name in file_names(marks)), shown, strict=True))


Cell = str | float

TABLES = ('grades.csv', 'moodle.csv', 'canvas.csv')
"""Names of the tables of a class."""

_UTF_8 = '\ufeff'  # shows the encoding to Excel; Moodle and Canvas remove it
_FORMULA = ('=', '+', '-', '@', '＝', '＋', '－', '＠')
_GRADES_HEADER = ('student', 'id', 'email', 'submission', 'file', 'points', 'of', 'remarks')
_MOODLE_HEADER: list[Cell] = [
    'Identifier', 'Full name', 'Email address', 'Grade', 'Maximum grade', 'Last modified (grade)',
    'Feedback comments',
]  # fmt: skip
_CANVAS_HEADER: list[Cell] = ['Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section']


def tables_of(marks: Sequence[Marks]) -> dict[str, str]:
    """Return the tables of a class with at least one submission: contents by name."""
    tables = (_grades(marks), [_MOODLE_HEADER, *map(_moodle_row, marks)], _canvas(marks))
    return {name: _csv(rows) for name, rows in zip(TABLES, tables, strict=True)}


def _csv(rows: Iterable[Iterable[Cell]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator='\n').writerows(map(_cell, row) for row in rows)
    return f'{_UTF_8}{text.getvalue()}'


def _cell(cell: Cell) -> Cell:
    """Return a cell; a text that a spreadsheet would evaluate begins with an apostrophe."""
    if not isinstance(cell, str):
        return f'{cell:.6g}'
    plain = ' '.join(''.join(c if c.isprintable() else ' ' for c in cell).split())
    return f"'{plain}" if plain.startswith(_FORMULA) else plain


def _grades(marks: Sequence[Marks]) -> list[list[Cell]]:
    """Return the rows for teachers: points and figures of every criterion."""
    names = names_of(marks)
    header: list[Cell] = [*_GRADES_HEADER]
    for name, mark in _criteria(marks[0]):
        unit = f' ({mark.unit})' if mark.unit else ''
        header += [name, f'{name}: reached{unit}']
    is_corrected = any(one.corrections for one in marks)
    rows: list[list[Cell]] = []
    for one in marks:
        student = one.student
        row: list[Cell] = [student.name, student.id, student.email, one.submission, one.file]
        row += [_score(one), one.max_score, remark(one, names)]
        for _, mark in _criteria(one):
            row += [
                '' if one.failure else mark.points,
                '' if mark.reached is None else mark.reached,
            ]
        if is_corrected:
            row += [one.automatic, '; '.join(map(str, one.corrections))]
        rows.append(row)
    return [header + ['automatic', 'corrections'] * is_corrected, *rows]


def _score(marks: Marks) -> Cell:
    return marks.score if marks.is_decided else ''


def _criteria(marks: Marks) -> Iterator[tuple[str, CriterionMark]]:
    for scenario in marks.scenarios:
        for mark in scenario.criteria:
            yield f'{scenario.name}: {mark.name}', mark


def _moodle_row(marks: Marks) -> list[Cell]:
    student = marks.student
    number = f'Participant {student.id}' if student.id.isdecimal() else student.id
    text = escape('\n'.join(lines_of(student_view(marks)))).replace('  ', '&nbsp; ')
    text = text.replace('\n', '<br>')
    return [number, student.name, student.email, _score(marks), marks.max_score, '', text]


def _canvas(marks: Sequence[Marks]) -> list[list[Cell]]:
    most: list[Cell] = ['Points Possible', '', '', '', '', marks[0].max_score]
    return [[*_CANVAS_HEADER, marks[0].title], most, *map(_canvas_row, marks)]


def _canvas_row(marks: Marks) -> list[Cell]:
    student = marks.student
    number = student.id if student.id.isdecimal() else ''
    login = '' if number else student.id or student.email
    return [student.name, number, '', login, '', _score(marks)]
