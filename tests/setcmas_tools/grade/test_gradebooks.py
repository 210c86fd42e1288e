"""Tables of a graded class."""

import csv
import io
from dataclasses import replace
from itertools import product

import pytest
from graded_classes import graded_class

from setcmas_tools.grade.gradebooks import TABLES, tables_of
from setcmas_tools.grade.marks import Failure
from setcmas_tools.submissions.student import Student

CLASS = graded_class()
HIDDEN = ('', ' ', '\n', '\t', '\u200b', '\ufeff', '\u202e', '\x00', ' \u200b\r\n ')


def rows_of(name, marks=CLASS):
    """Return the rows of a table, as platforms read it: the mark of its encoding is taken off."""
    text = tables_of(marks)[name]
    assert text.startswith('\ufeff')  # Excel would take it for another encoding
    return list(csv.reader(io.StringIO(text.removeprefix('\ufeff'))))


def test_students_see_nothing_that_is_hidden_and_points_are_the_same_in_all_tables():
    scores = [one.score for one in CLASS]

    for name, column in (('grades.csv', 'points'), ('moodle.csv', 'Grade')):
        header, *rows = rows_of(name)
        assert [float(row[header.index(column)]) for row in rows] == scores
    header, _, *rows = rows_of('canvas.csv')
    assert [float(row[header.index('Consensus: the lab')]) for row in rows] == scores
    for name in ('moodle.csv', 'canvas.csv'):
        assert 'SECRET' not in tables_of(CLASS)[name]


def test_a_grade_that_needs_a_decision_is_empty_in_all_tables():
    undecided = replace(CLASS[0], failure=Failure('a.py and b.py both have a function control'))
    marks = [undecided, *CLASS[1:]]

    for name, column in (('grades.csv', 'points'), ('moodle.csv', 'Grade')):
        header, first, *_ = rows_of(name, marks)
        assert first[header.index(column)] == ''
    header, _, first, *_ = rows_of('canvas.csv', marks)
    assert first[header.index('Consensus: the lab')] == ''
    feedback = rows_of('moodle.csv', marks)[1][6]
    assert feedback == 'Not marked: a.py and b.py both have a function control'
    assert rows_of('grades.csv', marks)[1][8] == ''


def test_moodle_and_canvas_know_students_by_their_numbers():
    header, first, *_ = rows_of('moodle.csv')
    assert (header[0], first[0]) == ('Identifier', 'Participant 12345')
    assert {'Grade', 'Last modified (grade)', 'Feedback comments'} <= {*header}
    assert '<script' not in rows_of('moodle.csv')[2][6]

    header, most, first, *_ = rows_of('canvas.csv')
    assert header[:5] == ['Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section']
    assert (most[0], most[5]) == ('Points Possible', '8.5')
    assert first == ['Ada Lovelace', '12345', '', '', '', '5.5']


@pytest.mark.parametrize('name', TABLES)
def test_no_spreadsheet_computes_a_name_whatever_a_student_is_called(name):
    students = [
        replace(CLASS[0], submission=text, student=Student(text, text, text))
        for sign, hidden in product('=+-@＝', HIDDEN)
        for text in [f'{hidden}{sign}HYPERLINK("http://x";1)\udcff']
    ]

    rows = rows_of(name, students)
    shown = [''.join(filter(str.isprintable, cell)).strip() for row in rows for cell in row]
    assert any('HYPERLINK' in cell for cell in shown)
    assert not [cell for cell in shown if cell.startswith(tuple('=+-@＝'))]
