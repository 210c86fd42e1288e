"""The format `csv`: all that is known of a class, a row for each submission, for teachers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from setcmas_tools.grade_formats.format import Files, GradeFormat
from setcmas_tools.grade_formats.spreadsheet import csv_text
from setcmas_tools.grading.marks import CriterionMark, Marks
from setcmas_tools.grading.pages.remarks import names_of, remark

Cell = str | float


def _files(marks: Sequence[Marks]) -> Files:
    names = names_of(marks)
    header: list[Cell] = ['student', 'id', 'email', 'submission', 'points', 'of', 'remarks']
    for name, mark in _criteria(marks[0]):
        unit = f' ({mark.unit})' if mark.unit else ''
        header += [name, f'{name}: reached{unit}']
    return {'grades.csv': csv_text([header, *(_row(one, names) for one in marks)])}


def _row(marks: Marks, names: Mapping[str, str]) -> list[Cell]:
    student = marks.student
    row: list[Cell] = [student.name, student.id, student.email, marks.submission]
    row += [marks.score, marks.max_score, remark(marks, names)]
    for _, mark in _criteria(marks):
        row += [mark.points, '' if mark.reached is None else mark.reached]
    return row


def _criteria(marks: Marks) -> Iterator[tuple[str, CriterionMark]]:
    for scenario in marks.scenarios:
        for mark in scenario.criteria:
            yield f'{scenario.name}: {mark.name}', mark


CSV = GradeFormat('spreadsheets: points and figures of every criterion, for teachers', _files)
