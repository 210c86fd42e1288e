"""Tables of a graded class: plain CSV, Moodle's grading worksheet and Canvas's gradebook."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape

from setcmas_tools.grade.check import student_view
from setcmas_tools.grade.criteria import points_text
from setcmas_tools.grade.mark_pages import failure_line, names_of, remark
from setcmas_tools.grade.marks import CriterionMark, Failure, Marks

Cell = str | float

TABLES = ('grades.csv', 'moodle.csv', 'canvas.csv')
"""Names of the tables of a class."""

_UTF_8 = '\ufeff'  # shows the encoding to Excel; Moodle and Canvas remove it
_FORMULA = ('=', '+', '-', '@', '＝', '＋', '－', '＠')
_UNFILLED = 'Not filled in yet: this is the original exercise.'
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
    csv.writer(text, lineterminator='\n').writerows(map(_safe, row) for row in rows)
    return f'{_UTF_8}{text.getvalue()}'


def _safe(cell: Cell) -> Cell:
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
    rows = [_grades_row(one, names) for one in marks]
    if any(one.corrections for one in marks):
        header += ['automatic', 'corrections']
        for row, one in zip(rows, marks, strict=True):
            row += [one.automatic, _corrections(one)]
    return [header, *rows]


def _grades_row(marks: Marks, names: Mapping[str, str]) -> list[Cell]:
    student = marks.student
    row: list[Cell] = [student.name, student.id, student.email, marks.submission, marks.file]
    row += [_score(marks), marks.max_score, remark(marks, names)]
    for _, mark in _criteria(marks):
        points = '' if marks.failure else mark.points
        row += [points, '' if mark.reached is None else mark.reached]
    return row


def _score(marks: Marks) -> Cell:
    return marks.score if marks.is_decided else ''


def _corrections(marks: Marks) -> str:
    return '; '.join(map(str, marks.corrections))


def _criteria(marks: Marks) -> Iterator[tuple[str, CriterionMark]]:
    for scenario in marks.scenarios:
        for mark in scenario.criteria:
            yield f'{scenario.name}: {mark.name}', mark


def _moodle_row(marks: Marks) -> list[Cell]:
    student = marks.student
    number = f'Participant {student.id}' if student.id.isdecimal() else student.id
    text = escape(feedback(student_view(marks))).replace('  ', '&nbsp; ')
    text = text.replace('\n', '<br>')
    return [number, student.name, student.email, _score(marks), marks.max_score, '', text]


def _canvas(marks: Sequence[Marks]) -> list[list[Cell]]:
    most: list[Cell] = ['Points Possible', '', '', '', '', marks[0].max_score]
    rows = [[*_CANVAS_HEADER, marks[0].title], most, *map(_canvas_row, marks)]
    if any(one.corrections for one in marks):  # in Canvas's column for notes of teachers
        notes = map(_corrections, map(student_view, marks))
        columns = ['Notes', '', *notes]
        rows = [[*row[:5], note, *row[5:]] for row, note in zip(rows, columns, strict=True)]
    return rows


def _canvas_row(marks: Marks) -> list[Cell]:
    student = marks.student
    number = student.id if student.id.isdecimal() else ''
    login = '' if number else student.id or student.email
    return [student.name, number, '', login, '', _score(marks)]


def feedback(marks: Marks) -> str:
    """Return the complete feedback for a student as text."""
    lines = [f'File: {marks.own_file}'] if marks.file else []
    lines += [_UNFILLED] if marks.unfilled else []
    if marks.failure:
        lines.append(f'Not marked: {_failure(marks.failure)}')
    if marks.corrections:
        lines.append(f'{_line("Automatic mark", marks.automatic, marks.max_score)}. Corrections:')
        lines += map(str, marks.corrections)
        lines.append(_line('Corrected mark', marks.score, marks.max_score))
    for scenario in () if marks.failure else marks.scenarios:
        lines.append(_line(scenario.name, scenario.points, scenario.max_points))
        failed = [_failure(scenario.failure)] if scenario.failure else []
        for mark in scenario.criteria:
            sign = '✓' if mark.is_full else '✗'
            lines.append(f'{sign} {_line(mark.name, mark.points, mark.max_points)}')
            figures = '' if mark.hidden else f'wanted {mark.wanted}, reached {mark.reached_text}'
            lines += filter(None, [*failed, figures, mark.hint])
            failed = []
    return '\n'.join(lines)


def _failure(failure: Failure) -> str:
    """Return an error with the lines of the script around it."""
    if not failure.line:
        return failure.message
    lines = [
        f'{">" if number == failure.line else " "} {number:4} {text}'
        for number, text in enumerate(failure.around, start=failure.first)
    ]
    return '\n'.join([failure_line(failure), *lines])


def _line(name: str, points: float, most: float) -> str:
    return f'{name}: {points_text(points)} of {points_text(most)}'
