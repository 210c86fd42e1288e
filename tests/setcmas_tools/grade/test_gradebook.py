"""Pages and tables of a graded class."""

import csv
import io
import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
from graded_classes import HOSTILE, graded_class, marks_of
from report_pages import Page

from setcmas_tools.grade.gradebook import (
    TABLES,
    file_names,
    marks_table,
    pages_of,
    remark,
    tables_of,
)
from setcmas_tools.grade.mark_records import Correction, Failure
from setcmas_tools.submissions.submitted_files import Student


def test_names_are_safe_and_unique_on_systems_that_ignore_case():
    students = ['Ada', 'ada', '../../etc/passwd', '<>|', 'x' * 300, 'Bülent Çelik', 'con*']
    names = file_names([marks_of(one, 1.0, id='7' * (one == 'con*')) for one in students])

    assert names == ['Ada', 'ada_2', 'etc_passwd', 'student', 'x' * 80, 'Bulent_Celik', 'con_7']


PAGES = pages_of(graded_class())


def test_names_and_messages_are_text_and_nothing_is_fetched():
    shown = ''.join(Page(text).shown for text in PAGES.values())
    assert HOSTILE in shown
    for text in PAGES.values():
        page = Page(text)
        attributes = [one for _, found in page.elements for one in found.items()]
        links = {value for name, value in attributes if name in ('href', 'src')}

        assert 'script' not in {tag for tag, _ in page.elements}
        assert not {'javascript:', '//'} & {part for link in links for part in link.split(':')}
        assert not [name for name, _ in attributes if name.startswith('on')]
        assert not re.search('[\x00-\x08\x0e-\x1f]', page.shown)


def test_a_student_sees_the_own_failure_and_nothing_hidden_nor_of_other_students():
    for path, text in PAGES.items():
        assert 'SECRET' not in text
        assert ('Lovelace' in text) == ('Lovelace' in path)
    shown = Page(PAGES['students/Celik_Bulent.html']).shown
    assert 'too many values to unpack (law.py, line 2)' in shown
    assert 'robot 3, t = 0.4 s' in shown
    assert '2 | x, y = poses[:, robotNo]' in shown


def test_a_bonus_fills_the_bar_of_a_page_at_most_and_ends_the_remark_on_a_failure():
    bonus = Correction('bonus', 10.0, 'neat code', 'A. Assistant', '2026-11-22')
    full, _, failed, _ = (replace(one, corrections=(bonus,)) for one in graded_class())

    [page] = pages_of([full]).values()
    assert '<i class="good" style="width:100.0%">' in page
    assert remark(failed, {}).startswith('ValueError')
    assert remark(graded_class()[1], {}).startswith('Each robot should go towards the mean')
    assert remark(failed, {}).endswith('bonus +10: neat code (A. Assistant, 2026-11-22)')


@pytest.mark.nightly
@pytest.mark.usefixtures('needs_chromium')
@pytest.mark.parametrize('width', [390, 1366])
def test_pages_fit_their_window_and_run_no_script(tmp_path, width):
    from browser import open_browser

    for path, text in PAGES.items():
        (tmp_path / Path(path).name).write_text(text)
    with open_browser(width, 800) as browser:
        size = {'width': width, 'height': 800, 'deviceScaleFactor': 1, 'mobile': False}
        browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', size)
        for path in tmp_path.iterdir():
            browser.get(path.as_uri())
            assert browser.title != 'forged'
            script = 'return document.documentElement.scrollWidth'
            assert browser.execute_script(script) == width


def test_names_with_control_characters_do_not_reach_the_terminal():
    table = marks_table(graded_class())

    assert 'points of 8.5' in table
    assert all(each.isprintable() or each == '\n' for each in table)
    assert len(table.splitlines()) == 6


CLASS = graded_class()
HIDDEN = ('', ' ', '\n', '\t', '\u200b', '\ufeff', '\u202e', '\x00', ' \u200b\r\n ')
COLUMNS = {'grades.csv': 'points', 'moodle.csv': 'Grade', 'canvas.csv': 'Consensus: the lab'}


def rows_of(name, marks=CLASS):
    """Return the rows of a table, as platforms read it: the mark of its encoding is taken off."""
    text = tables_of(marks)[name]
    assert text.startswith('\ufeff')  # Excel would take it for another encoding
    return list(csv.reader(io.StringIO(text.removeprefix('\ufeff'))))


@pytest.mark.parametrize('name', TABLES)
def test_points_are_the_same_in_all_tables_and_empty_where_a_decision_is_needed(name):
    undecided = replace(CLASS[0], failure=Failure('a.py and b.py both have a function control'))

    header, *rows = rows_of(name, [undecided, *CLASS[1:]])
    points = [row[header.index(COLUMNS[name])] for row in rows[-len(CLASS) :]]
    assert points[0] == ''
    assert [float(one) for one in points[1:]] == [one.score for one in CLASS[1:]]
    assert ('SECRET' in tables_of(CLASS)[name]) == (name == 'grades.csv')
    if name == 'moodle.csv':
        assert rows[0][6].endswith('not marked: a.py and b.py both have a function control')


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
