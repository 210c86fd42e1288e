import os
import shutil
import zipfile

import pytest
from hostile_submissions import PACKED, archive

from setcmas_simu.errors import SetcmasError
from setcmas_tools.submissions import submitted_files
from setcmas_tools.submissions.submissions import find_submissions

LAW = b'import numpy\ndef control(i, n, poses, t):\n    return 0, 0\n'
WITH_TEST = {
    'law.py': LAW,
    'test_law.py': b'from law import control\n\ndef test_it():\n    control()\n',
}
IMPORTING = b'from maths import f\n' + LAW
MOODLE = 'cid_1_assignsubmission_file_'
CANVAS = 'kinga_LATE_12_'


def found(tmp_path, files, name='class'):
    place = tmp_path / name
    if name.endswith('.zip'):
        place.write_bytes(archive(files))
    else:
        for path, source in files.items():
            (place / path).parent.mkdir(parents=True, exist_ok=True)
            (place / path).write_bytes(source)
    return {one.name: one for one in find_submissions(place, 'control')}


@pytest.mark.parametrize('name', ['class', 'class.zip'])
def test_scripts_folders_and_zip_files_are_submissions_of_a_class(tmp_path, name):
    files = {
        'ada.py': LAW,
        'bob/tp1/law.py': IMPORTING,
        'bob/tp1/maths.py': LAW,
        'bob/readme.txt': b'',
        f'{MOODLE}/law.zip': archive({'law.py': LAW, '__MACOSX/law.py': b''}),
        '.DS_Store': b'',
        'notes.txt': b'',
    }

    submissions = found(tmp_path, files, name)

    assert list(submissions) == ['ada.py', 'bob', MOODLE]
    assert submissions['bob'].script == 'law.py'
    assert submissions['bob'].files.keys() == {'law.py', 'maths.py'}
    assert submissions[MOODLE].student.name == 'cid'
    assert submissions[MOODLE].script == 'law.py'


@pytest.mark.parametrize('name', ['all', 'all.zip'])
@pytest.mark.parametrize('names', [['ada/law.py', 'bob/law.py'], ['Ada.py', 'bob.py']])
def test_a_lone_folder_with_the_scripts_of_several_is_the_class(tmp_path, name, names):
    files = {f'class/hand-in/{name}': LAW for name in names}

    assert list(found(tmp_path, files, name)) == [name.partition('/')[0] for name in names]


def test_a_lone_folder_with_a_script_and_its_module_is_a_students(tmp_path):
    files = {'bob/law.py': IMPORTING, 'bob/maths.py': b''}

    assert list(found(tmp_path, files)) == ['bob']


def test_a_student_whose_folder_is_empty_is_not_lost(tmp_path):
    (tmp_path / 'class/ada').mkdir(parents=True)

    submissions = found(tmp_path, {'bob.py': LAW})

    assert submissions['ada'].problem == 'the submission is empty'


def test_files_that_canvas_numbers_are_one_submission_of_the_newest(tmp_path):
    old, new = b'# old\n' + LAW, b'# new\n' + LAW
    files = {f'{CANVAS}9_law.py': old, f'{CANVAS}11_law-1.py': new, f'{CANVAS}10_x.py': b''}

    (submission,) = found(tmp_path, files).values()

    assert submission.name == f'{CANVAS}11_law-1.py'
    assert submission.student.name == 'kinga'
    assert submission.files == {'law.py': new, 'x.py': b''}


@pytest.mark.parametrize(
    ('files', 'problem'),
    [
        ({'a.py': LAW, 'b.py': LAW}, 'a.py and b.py both have a function control'),
        ({'a.py': b'', 'b.py': b''}, 'none of its 2 scripts has a function control'),
        ({'law.ipynb': b'{}'}, 'law.ipynb: it is not a notebook of Jupyter, or damaged'),
        ({'law.zip': b'no zip file'}, 'law.zip is damaged'),
        ({'law.py': LAW, 'b.py': b'#' * 299_999}, 'have 300 kB, but at most 200 kB are allowed'),
        ({'law.py': LAW + b'#' * 2_000_000}, 'at most 200 kB are allowed'),
        ({'law.py': b'def control(:\n', 'gains.py': b''}, 'law.py, line 1: SyntaxError'),
        # several laws are named, and none is guessed
        (WITH_TEST | {'law_old.py': LAW}, 'law.py and law_old.py both have'),
        (WITH_TEST | {'consensus.py': LAW}, 'consensus.py and law.py both have'),
        ({'a.py': LAW, 'b.py': LAW, 'v2/c.py': LAW}, 'a.py and b.py and v2/c.py all have'),
        ({'a.py': LAW, 'b.py': LAW}, 'leave only the one to be marked in the submission'),
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
        ({'ada/law.py': LAW, 'ada/test_law.py': b'from law import control\n'}, 'ada/law.py'),
        ({'ada/tp/law.py': b'control = print\n', 'ada/tp/gains.py': b''}, 'ada/tp/law.py'),
        ({'ada/main.py': b'import more\n' + LAW, 'ada/more.py': b'import law\n',
          'ada/law.py': LAW}, 'ada/main.py'),
        ({'ada.zip': archive({'law.py': LAW})}, 'ada.zip/law.py'),
        ({'ada.py': LAW}, 'ada.py'),
    ],
)  # fmt: skip
def test_each_submission_names_the_file_to_mark(tmp_path, files, file):
    one, *_ = found(tmp_path, {**files, 'bob.py': LAW}).values()

    assert one.file == file


def test_links_are_not_followed(tmp_path):
    (tmp_path / 'rubric.yaml').write_text('secret')
    for student in ('ada', 'cid'):
        (tmp_path / 'class' / student).mkdir(parents=True)
    (tmp_path / 'class/ada/secret.py').symlink_to(tmp_path / 'rubric.yaml')
    (tmp_path / 'class/cid/secret.py').hardlink_to(tmp_path / 'rubric.yaml')

    submissions = found(tmp_path, {'ada/law.py': LAW})

    assert submissions['ada'].files.keys() == {'law.py'}
    assert submissions['cid'].problem.startswith('secret.py is a hard link')


def test_a_class_of_hard_links_is_refused_as_a_whole(tmp_path):
    found(tmp_path, {'ada.py': LAW, 'bob/law.py': LAW})
    shutil.copytree(tmp_path / 'class', tmp_path / 'copy', copy_function=os.link)

    with pytest.raises(SetcmasError, match='holds only hard links, as cp -al makes them'):
        find_submissions(tmp_path / 'copy', 'control')


def test_a_student_cannot_pass_for_a_folder_of_grades(tmp_path):
    files = {'ada/law.py': LAW, f'ada/marks/{"a" * 64}.json': b'{}', 'bob.py': LAW}

    assert list(found(tmp_path, files)) == ['ada', 'bob.py']


def branched(depth):
    """Return an archive that unpacks to 100 to the power of depth files."""
    content = archive({'law.py': LAW})
    for _ in range(depth):
        content = archive({f'{k}.zip': content for k in range(100)}, zipfile.ZIP_DEFLATED)
    return content


BOMBS = {
    'depth': (lambda: PACKED['depth.zip'][0], '3 zip files in each other'),
    'files': (lambda: branched(2), '1,000 files'),
    'bytes': (
        lambda: archive({f'{k}.py': bytes(1 << 20) for k in range(99)}, zipfile.ZIP_DEFLATED),
        '16 MB',
    ),
    'zip file': (
        lambda: archive({'a.zip': archive({'b.py': bytes(1 << 26)})}, zipfile.ZIP_DEFLATED),
        '16 MB',
    ),
    'method': (lambda: archive({'a.py': bytes(1 << 20)}, zipfile.ZIP_BZIP2), 'unusual method'),
}


@pytest.mark.parametrize('name', BOMBS)
@pytest.mark.parametrize('place', ['class', 'class.zip'])
def test_an_archive_that_unpacks_to_too_much_costs_its_student_alone(tmp_path, name, place):
    bomb, problem = BOMBS[name]

    submissions = found(tmp_path, {'ada.py': LAW, 'bob.zip': bomb(), 'cid.py': LAW}, place)

    assert list(submissions) == ['ada.py', 'bob.zip', 'cid.py']
    assert problem in submissions['bob.zip'].problem


def test_a_video_in_an_archive_is_left_out_and_the_law_is_read(tmp_path):
    video = os.urandom(20 << 20)

    ada = found(tmp_path, {'ada.zip': archive({'law.py': LAW, 'video.mp4': video})})['ada.zip']

    assert ada.problem == ''
    assert ada.script == 'law.py'


def test_an_entry_with_an_absolute_path_stays_away_from_other_students(tmp_path):
    files = {'ada.py': LAW, 'bob.py': LAW, 'mal.zip': archive({'law.py': LAW, '//x/y.txt': b'x'})}

    assert list(found(tmp_path, files)) == ['ada.py', 'bob.py', 'mal.zip']


def test_a_class_has_a_limit_too(tmp_path, monkeypatch):
    monkeypatch.setattr(submitted_files, '_MOST_OF_CLASS', (5, 1 << 20))

    with pytest.raises(SetcmasError, match='more than 5 files or 1 MB; grade it in parts'):
        found(tmp_path, {f'{k}.py': LAW for k in range(6)})


def test_names_of_any_bytes_can_be_written(tmp_path):
    (tmp_path / 'class').mkdir()
    (tmp_path / 'class' / os.fsdecode(b'b\xff.py')).write_bytes(LAW)

    for submission in found(tmp_path, {'ada.py': LAW}).values():
        (submission.name + submission.script + submission.student.name).encode()


def test_a_folder_without_submissions_says_what_it_must_be(tmp_path):
    with pytest.raises(SetcmasError, match='holds no submissions; it must be a folder'):
        found(tmp_path, {'readme.txt': b''})
    with pytest.raises(SetcmasError, match='neither a folder nor a zip file'):
        find_submissions(tmp_path / 'class/readme.txt', 'ctc')
