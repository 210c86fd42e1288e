"""The format `moodle`: the grading worksheet of a Moodle assignment.

Moodle takes it with Assignment > Submissions > Upload grading worksheet, if `Offline grading
worksheet` and `Feedback comments` are on. Columns as in Moodle's mod/assign/feedback/offline,
in English; `Participant N` is the number that stands in the names of downloaded submissions.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from setcmas_tools.grade_formats.feedback import feedback
from setcmas_tools.grade_formats.format import Files, GradeFormat
from setcmas_tools.grade_formats.spreadsheet import csv_text
from setcmas_tools.grading.marks import Marks
from setcmas_tools.grading.student_view import student_view

_HEADER = (
    'Identifier', 'Full name', 'Email address', 'Grade', 'Maximum grade', 'Last modified (grade)',
    'Feedback comments',
)  # fmt: skip


def _files(marks: Sequence[Marks]) -> Files:
    return {'moodle.csv': csv_text([_HEADER, *map(_row, marks)])}


def _row(marks: Marks) -> list[str | float]:
    student = marks.student
    number = f'Participant {student.id}' if student.id.isdecimal() else student.id
    told = escape(feedback(student_view(marks))).replace('  ', '&nbsp; ')
    told = told.replace('\n', '<br>')
    return [number, student.name, student.email, marks.score, marks.max_score, '', told]


MOODLE = GradeFormat("Moodle's grading worksheet", _files)
