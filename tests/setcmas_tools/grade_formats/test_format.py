"""Every format: what it writes fits what its platform documents, and hides what is hidden."""

import csv
import io
import json
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from graded_classes import HOSTILE, graded_class
from jsonschema import validate
from platform_schemas import SCHEMAS

from setcmas_tools.grade_formats.format import GRADE_FORMATS, write_formats
from setcmas_tools.grading.marks import Failure
from setcmas_tools.grading.pages.pages import write_pages

CLASS = graded_class()


def files(name, marks=CLASS):
    return GRADE_FORMATS.get(name).files(marks)


def rows_of(name):
    """Return the rows of a table, as platforms read it: the mark of its encoding is taken off."""
    [text] = files(name).values()
    assert text.startswith('\ufeff')  # Excel would take it for another encoding
    return list(csv.reader(io.StringIO(text.removeprefix('\ufeff'))))


@pytest.mark.parametrize('name', SCHEMAS)
def test_each_result_is_as_its_platform_documents(name):
    dead = replace(CLASS[0], failure=Failure(f'SyntaxError: {HOSTILE}'), unfilled=True)
    results = files(name, [*CLASS, dead])

    assert len(results) == 5
    for text in results.values():
        validate(json.loads(text), SCHEMAS[name])


@pytest.mark.parametrize('name', [*SCHEMAS, 'junit', 'moodle', 'canvas'])
def test_what_students_see_has_nothing_that_is_hidden(name):
    for text in files(name).values():
        assert 'SECRET' not in str(text)


def test_points_are_the_same_everywhere():
    scores = [one.score for one in CLASS]

    def results(name):
        return map(json.loads, files(name).values())

    for result in results('gradescope'):
        assert result['score'] == sum(test['score'] for test in result['tests'])
    assert [result['score'] for result in results('gradescope')] == scores
    shares = [result['fraction'] * 8.5 for result in results('coderunner')]
    assert shares == pytest.approx(scores, abs=1e-3)
    for name, column in (('csv', 'points'), ('moodle', 'Grade')):
        header, *rows = rows_of(name)
        assert [float(row[header.index(column)]) for row in rows] == scores


def test_coderunner_shows_a_message_as_text():
    for text in files('coderunner').values():
        result = json.loads(text)
        assert '<script' not in result['prologuehtml'] + result['epiloguehtml']


def test_moodle_and_canvas_know_students_by_their_numbers():
    header, first, *_ = rows_of('moodle')
    assert (header[0], first[0]) == ('Identifier', 'Participant 12345')
    assert {'Grade', 'Last modified (grade)', 'Feedback comments'} <= {*header}

    header, most, first, *_ = rows_of('canvas')
    assert header[:5] == ['Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section']
    assert (most[0], most[5]) == ('Points Possible', '8.5')
    assert first == ['Ada Lovelace', '12345', '', '', '', '5.5']


def test_no_spreadsheet_computes_a_name():
    for name in ('csv', 'moodle', 'canvas'):
        cells = [cell for row in rows_of(name) for cell in row]
        assert not [cell for cell in cells if cell.startswith(('=', '+', '@'))]


def test_junit_counts_a_test_for_each_criterion():
    [text] = files('junit').values()
    root = ElementTree.fromstring(text)

    assert (root.get('tests'), root.get('failures')) == ('16', '10')
    assert len(root.findall('testsuite/testcase/failure')) == 10
    assert HOSTILE in root.findtext('testsuite[3]/system-err')


def test_files_are_the_same_twice_whatever_a_student_is_called(tmp_path):
    marks = [*CLASS, replace(CLASS[0], student=replace(CLASS[0].student, name='\udcff'))]
    written = []
    for folder in (tmp_path / 'a', tmp_path / 'b'):
        folder.mkdir()
        write_formats(list(GRADE_FORMATS.offers()), marks, folder)
        write_pages(marks, folder)
        files = (path for path in folder.rglob('*') if path.is_file())
        written.append({path.relative_to(folder): path.read_bytes() for path in files})

    assert written[0] == written[1]
    assert len(written[0]) == 1 + 5 + 4 + 2 * 5
