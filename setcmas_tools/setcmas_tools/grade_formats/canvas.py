"""The format `canvas`: a table that the gradebook of Canvas imports.

Columns as in Canvas's lib/gradebook_importer.rb: students are found by ID (the first number in the
names of downloaded submissions), by login or by name.
"""

from __future__ import annotations

from collections.abc import Sequence

from setcmas_tools.grade_formats.format import Files, GradeFormat
from setcmas_tools.grade_formats.spreadsheet import csv_text
from setcmas_tools.grading.marks import Marks

_HEADER = ('Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section')


def _files(marks: Sequence[Marks]) -> Files:
    most: list[str | float] = ['Points Possible', '', '', '', '', marks[0].max_score]
    return {'canvas.csv': csv_text([[*_HEADER, marks[0].title], most, *map(_row, marks)])}


def _row(marks: Marks) -> list[str | float]:
    student = marks.student
    number = student.id if student.id.isdecimal() else ''
    login = '' if number else student.id or student.email
    return [student.name, number, '', login, '', marks.score]


CANVAS = GradeFormat("Canvas's gradebook", _files)
