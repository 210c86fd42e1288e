"""Gradebooks: plain CSV, Moodle and Canvas."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape

from setcmas_tools.grade.check import student_view
from setcmas_tools.grade.mark_pages import names_of, remark
from setcmas_tools.grade.marks import CriterionMark, Marks
from setcmas_tools.platforms.grade_format import Files, GradeFormat, csv_text, feedback

Cell = str | float


def _csv_files(marks: Sequence[Marks]) -> Files:
    names = names_of(marks)
    first = 'student id email submission file points of remarks'
    header: list[Cell] = [*first.split()]
    for name, mark in _criteria(marks[0]):
        unit = f' ({mark.unit})' if mark.unit else ''
        header += [name, f'{name}: reached{unit}']
    rows = [header, *(_csv_row(one, names) for one in marks)]
    if any(one.corrections for one in marks):
        further: list[list[Cell]] = [[one.automatic, _corrections(one)] for one in marks]
        further.insert(0, ['automatic', 'corrections'])
        rows = [[*row, *more] for row, more in zip(rows, further, strict=True)]
    return {'grades.csv': csv_text(rows)}


def _csv_row(marks: Marks, names: Mapping[str, str]) -> list[Cell]:
    student = marks.student
    row: list[Cell] = [student.name, student.id, student.email, marks.submission, marks.file]
    row += [marks.score, marks.max_score, remark(marks, names)]
    for _, mark in _criteria(marks):
        row += [mark.points, '' if mark.reached is None else mark.reached]
    return row


def _corrections(marks: Marks) -> str:
    return '; '.join(map(str, marks.corrections))


def _criteria(marks: Marks) -> Iterator[tuple[str, CriterionMark]]:
    for scenario in marks.scenarios:
        for mark in scenario.criteria:
            yield f'{scenario.name}: {mark.name}', mark


CSV = GradeFormat('spreadsheets: points and figures of every criterion, for teachers', _csv_files)


_MOODLE_HEADER = (
    'Identifier', 'Full name', 'Email address', 'Grade', 'Maximum grade', 'Last modified (grade)',
    'Feedback comments',
)  # fmt: skip


def _moodle_files(marks: Sequence[Marks]) -> Files:
    return {'moodle.csv': csv_text([_MOODLE_HEADER, *map(_moodle_row, marks)])}


def _moodle_row(marks: Marks) -> list[str | float]:
    student = marks.student
    number = f'Participant {student.id}' if student.id.isdecimal() else student.id
    text = escape(feedback(student_view(marks))).replace('  ', '&nbsp; ')
    text = text.replace('\n', '<br>')
    return [number, student.name, student.email, marks.score, marks.max_score, '', text]


MOODLE = GradeFormat("Moodle's grading worksheet", _moodle_files)


_CANVAS_HEADER = ('Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section')


def _canvas_files(marks: Sequence[Marks]) -> Files:
    most: list[str | float] = ['Points Possible', '', '', '', '', marks[0].max_score]
    rows: list[list[Cell]] = [[*_CANVAS_HEADER, marks[0].title], most, *map(_canvas_row, marks)]
    if any(one.corrections for one in marks):  # in Canvas's column for notes of teachers
        notes = map(_corrections, map(student_view, marks))
        columns = ['Notes', '', *notes]
        rows = [[*row[:5], note, *row[5:]] for row, note in zip(rows, columns, strict=True)]
    return {'canvas.csv': csv_text(rows)}


def _canvas_row(marks: Marks) -> list[str | float]:
    student = marks.student
    number = student.id if student.id.isdecimal() else ''
    login = '' if number else student.id or student.email
    return [student.name, number, '', login, '', marks.score]


CANVAS = GradeFormat("Canvas's gradebook", _canvas_files)
