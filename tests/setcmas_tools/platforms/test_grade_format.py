"""Formats of grades, and what is in the bundles for platforms."""

import csv
import io
import json
import subprocess
import zipfile
from dataclasses import replace
from itertools import product
from xml.etree import ElementTree

import pytest
from graded_classes import HOSTILE, graded_class
from jsonschema import validate
from platform_schemas import SCHEMAS

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.mark_pages import write_pages
from setcmas_tools.grade.marks import Failure
from setcmas_tools.grade.rubric import rubric_of_exercise
from setcmas_tools.platforms.grade_format import (
    GRADE_FORMATS,
    format_files,
    make_bundle,
    write_files,
)
from setcmas_tools.submissions.student import Student

RUBRIC = rubric_of_exercise('consensus')


def bundle(name, options='', rubric=RUBRIC):
    return zipfile.ZipFile(io.BytesIO(make_bundle(name, rubric, options)))


def test_the_zip_of_gradescope_has_its_scripts_at_the_root_and_they_can_be_executed():
    archive = bundle('gradescope', '--trust')

    for name in ('setup.sh', 'run_autograder'):
        assert archive.getinfo(name).external_attr >> 16 & 0o777 == 0o755
    assert '--trust' in archive.read('run_autograder').decode()
    assert archive.read('rubric/consensus.yaml') == RUBRIC.file.read_bytes()


@pytest.mark.parametrize(
    ('name', 'paths'),
    [
        ('gradescope', {'setup.sh', 'run_autograder', 'rubric/consensus.yaml'}),
        ('coderunner', {'template.py', 'rubric.zip', 'README.txt'}),
    ],
)
def test_bundles_have_what_their_platform_looks_for_and_run_as_scripts(name, paths):
    archive = bundle(name)
    wheels = {path for path in archive.namelist() if path.endswith('.whl')}

    assert len(wheels) == 1
    assert {*archive.namelist()} - wheels == paths
    for path in paths:
        text = archive.read(path)
        if path.endswith('.py'):
            compile(text, path, 'exec')
        elif path.endswith('.json'):
            json.loads(text)
        elif text.startswith(b'#!'):
            subprocess.run(['bash', '-n'], input=text, check=True)


def test_a_bundle_is_the_same_twice():
    assert make_bundle('gradescope', RUBRIC) == make_bundle('gradescope', RUBRIC)


def test_modules_that_the_solution_imports_are_in_the_bundle(tmp_path):
    for name, text in {'rubric.yaml': '', 'law.py': 'import gains', 'gains.py': 'K = 1'}.items():
        (tmp_path / name).write_text(text)
    rubric = replace(RUBRIC, file=tmp_path / 'rubric.yaml', solution=tmp_path / 'law.py')

    assert bundle('gradescope', rubric=rubric).read('rubric/gains.py') == b'K = 1'


def test_files_outside_the_folder_of_a_rubric_are_reported(tmp_path):
    law = tmp_path / 'law.py'
    law.touch()

    with pytest.raises(SetcmasError, match=r"law.py' must be in the folder of the rubric"):
        make_bundle('gradescope', replace(RUBRIC, solution=law))
    with pytest.raises(SetcmasError, match='must be one of check, coderunner, gradescope'):
        make_bundle('junit', RUBRIC)


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


HIDDEN = ('', ' ', '\n', '\t', '\u200b', '\ufeff', '\u202e', '\x00', ' \u200b\r\n ')


@pytest.mark.parametrize('name', ['csv', 'moodle', 'canvas'])
def test_no_spreadsheet_computes_a_name(name):
    students = [
        replace(CLASS[0], submission=text, student=Student(text, text, text))
        for sign, hidden in product('=+-@＝', HIDDEN)
        for text in [f'{hidden}{sign}HYPERLINK("http://x";1)']
    ]
    [content] = GRADE_FORMATS.get(name).files(students).values()

    rows = csv.reader(io.StringIO(content.removeprefix('\ufeff')))
    shown = [''.join(filter(str.isprintable, cell)).strip() for row in rows for cell in row]
    assert any('HYPERLINK' in cell for cell in shown)
    assert not [cell for cell in shown if cell.startswith(tuple('=+-@＝'))]


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
        write_files(format_files(list(GRADE_FORMATS.plugins()), marks), folder)
        write_pages(marks, folder)
        files = (path for path in folder.rglob('*') if path.is_file())
        written.append({path.relative_to(folder): path.read_bytes() for path in files})

    assert written[0] == written[1]
    assert len(written[0]) == 1 + 5 + 4 + 2 * 5
