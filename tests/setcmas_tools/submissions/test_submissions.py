import os
import re
import zipfile

import pytest
from hostile_submissions import archive

from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.submissions import submitted_files
from setcmas_tools.submissions.submissions import read_submissions

LAW = b'import numpy\ndef control(i, n, poses, t):\n    return 0, 0\n'
WITH_TEST = {
    'law.py': LAW,
    'test_law.py': b'from law import control\n\ndef test_it():\n    control()\n',
}
OTHER = LAW + b'# another\n'
IMPORTING = b'from maths import f\n' + LAW
MOODLE = 'cid_1'
CANVAS = 'kinga_LATE_12_'


def read_here(place):
    return sorted(read_submissions(place, Function.CONTROL), key=lambda one: one.name)


def found(tmp_path, files, name='class'):
    place = tmp_path / name
    if name.endswith('.zip'):
        place.write_bytes(archive(files))
    else:
        for path, source in files.items():
            (place / path).parent.mkdir(parents=True, exist_ok=True)
            (place / path).write_bytes(source)
    return {one.name: one for one in read_here(place)}


@pytest.mark.parametrize('name', ['class', 'class.zip'])
def test_scripts_folders_and_zip_files_are_submissions_of_a_class(tmp_path, name):
    files = {
        'ada.py': LAW,
        'bob/tp1/law.py': IMPORTING,
        'bob/tp1/maths.py': b'',
        'bob/readme.txt': b'',
        f'{MOODLE}_assignsubmission_file_/law.zip': archive(
            {'law.py': LAW, '__MACOSX/law.py': b''}
        ),
        '.DS_Store': b'',
        'notes.txt': b'',
    }

    submissions = found(tmp_path, files, name)

    assert list(submissions) == ['ada.py', 'bob', MOODLE]
    assert submissions['bob'].script == 'law.py'
    assert submissions['bob'].files.keys() == {'law.py', 'maths.py'}
    assert submissions[MOODLE].student.name == 'cid'
    assert submissions[MOODLE].script == 'law.py'


@pytest.mark.parametrize(
    ('files', 'names'),
    [
        ({'class/ada/law.py': LAW, 'class/bob/law.py': LAW}, ['ada', 'bob']),
        ({'class/Ada.py': LAW, 'class/bob.py': LAW}, ['Ada.py', 'bob.py']),
        ({'bob/law.py': IMPORTING, 'bob/maths.py': b''}, ['bob']),
    ],
)
def test_a_lone_folder_with_the_scripts_of_several_is_the_class(tmp_path, files, names):
    assert list(found(tmp_path, files)) == names


def test_files_that_canvas_makes_anonymous_are_one_submission(tmp_path):
    files = {'anon_h7KqZ_LATE_9_law.py': IMPORTING, 'anon_h7KqZ_LATE_10_maths.py': b''}

    (submission,) = found(tmp_path, files).values()

    assert (submission.student.name, submission.script) == ('anon_h7KqZ', 'law.py')
    assert submission.files.keys() == {'law.py', 'maths.py'}


@pytest.mark.parametrize('module', ['C:\\tp\\régulateur.py', '/../../régulateur.py'])
def test_names_in_a_zip_file_are_read_as_each_system_writes_them(tmp_path, module):
    law = re.sub(r'[^/\\]+$', 'law.py', module)
    content = archive({law: IMPORTING, module: b'f = 1'})

    one, _ = found(tmp_path, {'ada.zip': content, 'bob.py': LAW}).values()

    assert one.problem == ''
    assert one.files.keys() == {'law.py', 'régulateur.py'}


@pytest.mark.parametrize(
    ('files', 'problem'),
    [
        ({'a.py': LAW, 'b.py': OTHER}, 'a.py and b.py both have a function control'),
        ({'a.py': b'', 'b.py': b''}, 'none of its 2 scripts has a function control'),
        ({'law.ipynb': b'{}'}, 'law.ipynb: it is not a Jupyter notebook, or it is damaged'),
        ({'law.zip': b'no zip file'}, 'law.zip is damaged'),
        ({'law.py': LAW, 'b.py': b'#' * 299_999}, 'have 300 kB, but at most 200 kB are allowed'),
        ({'law.py': LAW + b'#' * 2_000_000}, 'law.py is larger than 1 MB'),
        ({'law.zip': archive({'law.zip': LAW})}, 'law.zip is a zip file in a zip file'),
        ({'law.zip': archive({'law.py': LAW}, zipfile.ZIP_LZMA)}, 'in an unusual way'),
        ({'deep.ipynb': b'[' * 10**6}, 'it is not a Jupyter notebook, or it is damaged'),
        ({'law.zip': archive({'law.py': bytes(1 << 28)}, 8)}, 'is larger than 1 MB'),
        ({'law.zip': archive({f'{"a/" * 500}law.py': LAW})}, 'the path of law.py is too long'),
        ({'law.zip': archive(dict.fromkeys(map(str, range(2000)), b''))}, 'more than 1,000 files'),
        # several laws are named, and none is guessed
        (WITH_TEST | {'law_old.py': OTHER}, 'law.py and law_old.py both have'),
        ({'a.py': LAW, 'b.py': OTHER, 'v2/c.py': LAW}, 'a.py and b.py and v2/c.py all have'),
    ],
)
def test_a_submission_without_a_law_says_why(tmp_path, files, problem):
    handed_in = {f'ada/{name}': file for name, file in files.items()}

    ada = found(tmp_path, {**handed_in, 'bob.py': LAW})['ada']

    assert problem in ada.problem
    assert (ada.script, ada.file) == ('', '')


def test_a_student_who_hands_in_no_script_is_not_lost(tmp_path):
    (submission,) = found(tmp_path, {f'{CANVAS}9_report.pdf': b'', 'list.csv': b''}).values()

    assert submission.student.name == 'kinga'
    assert submission.problem == 'no Python file, only report.pdf'


@pytest.mark.parametrize(
    ('files', 'file'),
    [
        ({'ada/law.py': LAW, 'ada/test_law.py': b'from law import control\n'}, 'law.py'),
        ({'ada/tp/law.py': b'control = print\n', 'ada/tp/gains.py': b''}, 'tp/law.py'),
        ({'ada/law.py': b'def control(:\n', 'ada/gains.py': b''}, 'law.py'),
        ({'ada/law.py': b'\xef\xbb\xbfdef control(): 0\n', 'ada/gains.py': b''}, 'law.py'),
        ({'ada/law.py': LAW, 'ada/plots.py': b'title("control = on")\n'}, 'law.py'),
        ({'ada.zip': archive({'law.py': LAW, 'a.mp4': bytes(2 << 20)})}, 'ada.zip/law.py'),
        ({'ada.PY': LAW}, 'ada.py'),
        ({'ada.Zip': archive({'tp/LAW.PY': LAW})}, 'ada.zip/tp/LAW.py'),
        ({'ada/law.py': LAW, 'ada/law (1).py': LAW}, 'law (1).py'),  # copies of one law
    ],
)  # fmt: skip
def test_each_submission_names_the_file_to_mark(tmp_path, files, file):
    one, *_ = found(tmp_path, {**files, 'bob.py': LAW}).values()

    assert one.file == file


def test_links_are_not_followed(tmp_path):
    (tmp_path / 'rubric.yaml').write_text('secret')
    (tmp_path / 'class/ada').mkdir(parents=True)
    (tmp_path / 'class/ada/secret.py').symlink_to(tmp_path / 'rubric.yaml')
    (tmp_path / 'class/dan.py').symlink_to(tmp_path / 'rubric.yaml')

    submissions = found(tmp_path, {'ada/law.py': LAW})

    assert submissions['ada'].files.keys() == {'law.py'}
    assert submissions['dan.py'].problem.startswith('dan.py is a symbolic link or no file')


def test_an_archive_that_unpacks_to_too_much_costs_its_student_alone(tmp_path):
    bomb = archive({f'{k}.py': bytes(1 << 20) for k in range(99)}, zipfile.ZIP_DEFLATED)

    submissions = found(tmp_path, {'ada.py': LAW, 'bob.zip': bomb, 'cid.py': LAW})

    assert list(submissions) == ['ada.py', 'bob.zip', 'cid.py']
    assert '16 MB' in submissions['bob.zip'].problem


def test_a_class_has_a_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(submitted_files, '_OF_CLASS', (9, 1 << 20))

    with pytest.raises(SetcmasError, match='holds more than 9 files or 1 MB; grade it in parts'):
        found(tmp_path, {f'{k}.py': LAW for k in range(10)})


@pytest.mark.parametrize('path', [f'{"a/" * 2250}f.txt', f'{"c" * 300}.txt', 'law.py/f.txt'])
def test_what_no_disk_holds_is_left_out(tmp_path, path):
    one, _ = found(
        tmp_path, {'ada.zip': archive({'law.py': LAW, path: b''}), 'b.py': LAW}
    ).values()

    with one.unpacked() as script:
        assert script.read_bytes() == LAW


def test_a_damaged_file_of_a_class_costs_its_student_alone(tmp_path):
    content = bytearray(archive({'ada/law.py': os.urandom(999), 'bob/law.py': LAW}, 8))
    content[40:50] = b'\xff' * 10
    (tmp_path / 'class.zip').write_bytes(content)

    ada, bob = read_here(tmp_path / 'class.zip')

    assert (ada.problem, bob.problem) == ('law.py is damaged or has a password', '')


def test_names_of_any_bytes_can_be_written(tmp_path):
    (tmp_path / 'class').mkdir()
    (tmp_path / 'class' / os.fsdecode(b'b\xff.py')).write_bytes(LAW)

    for submission in found(tmp_path, {'ada.py': LAW}).values():
        (submission.name + submission.script + submission.student.name).encode()


def test_a_folder_without_submissions_says_what_it_must_be(tmp_path):
    with pytest.raises(SetcmasError, match='holds no submissions; it must be a folder'):
        found(tmp_path, {'readme.txt': b''})
    with pytest.raises(SetcmasError, match='neither a folder nor a zip file'):
        read_submissions(tmp_path / 'class/readme.txt', Function.CONDITION)
