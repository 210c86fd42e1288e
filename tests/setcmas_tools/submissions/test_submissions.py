import os
import re
import zipfile
from unicodedata import normalize

import pytest
from hostile_submissions import archive

from setcmas_simu.errors import SetcmasError
from setcmas_tools.submissions import submitted_files
from setcmas_tools.submissions.submissions import find_submissions

LAW = b'import numpy\ndef control(i, n, poses, t):\n    return 0, 0\n'
WITH_TEST = {
    'law.py': LAW,
    'test_law.py': b'from law import control\n\ndef test_it():\n    control()\n',
}
OTHER = LAW + b'# another\n'
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


@pytest.mark.parametrize(
    ('names', 'files'),
    [
        (['9_law-2.py', '11_gains-1.py'], ['gains.py', 'law.py']),
        (['9_step-1.py', '10_step-2.py', '11_law.py'], ['law.py', 'step-1.py', 'step-2.py']),
        (['9_law.py', '11_law.py'], ['law.py']),
    ],
)
def test_the_numbers_of_canvas_are_left_out_unless_two_files_would_have_one_name(
    tmp_path, names, files
):
    sources = {name: LAW if 'law' in name else b'' for name in names}

    handed_in = {f'{CANVAS}{name}': source for name, source in sources.items()}
    (submission,) = found(tmp_path, handed_in).values()

    assert sorted(submission.files) == files
    assert submission.problem == ''


def test_files_that_canvas_makes_anonymous_are_one_submission(tmp_path):
    files = {'anon_h7KqZ_LATE_9_law.py': IMPORTING, 'anon_h7KqZ_LATE_10_maths.py': b''}

    (submission,) = found(tmp_path, files).values()

    assert (submission.student.name, submission.script) == ('anon_h7KqZ', 'law.py')
    assert submission.files.keys() == {'law.py', 'maths.py'}


ACCENTED = 'from régulateur import f\n'.encode() + LAW


@pytest.mark.parametrize(
    ('module', 'written'),
    [
        ('tp/régulateur.py', ''),
        (normalize('NFD', 'tp/régulateur.py'), ''),
        ('C:\\tp\\régulateur.PY.txt', ''),
        ('/../../régulateur.py', ''),
        ('tp/r@@gulateur.py', 'é'.encode()),  # of macOS, which does not say that it is UTF-8
        ('tp/re@@gulateur.py', normalize('NFD', 'é').encode()[1:]),
        ('tp/r@@gulateur.py', b'\x82'),  # of Windows
    ],
)
def test_names_in_a_zip_file_are_read_as_each_system_writes_them(tmp_path, module, written):
    law = re.sub(r'[^/\\]+$', 'LAW.PY', module)
    stand_in = '@' * len(written)  # zipfile would add the flag of UTF-8
    content = archive({law: ACCENTED, module.replace('@@', stand_in): b'f = 1'})
    content = content.replace(stand_in.encode(), written) if written else content

    one, _ = found(tmp_path, {'ada.zip': content, 'bob.py': LAW}).values()

    assert one.problem == ''
    assert one.files.keys() == {'LAW.py', 'régulateur.py'}


def test_folders_of_a_class_are_known_by_backslashes_and_students_by_composed_accents(tmp_path):
    files = {f'{normalize("NFD", "Zoé")}_7_assignsubmission_file_\\law.py': LAW, 'bob\\a.py': LAW}

    for name in ('class', 'class.zip'):
        bob, zoe = found(tmp_path, files, name).values()
        assert (bob.student.name, zoe.student.name) == ('bob', 'Zoé')
        assert zoe.script == 'law.py'


def test_endings_in_capitals_or_with_what_windows_hides_are_those_of_scripts(tmp_path):
    files = {
        'ada.PY': LAW,
        'bob.py.txt': LAW,
        'cid.py ': LAW,
        'dan.Zip': archive({'tp/LAB.ZIP': archive({'LAW.PY': LAW})}),
        'eve/law.py': LAW,
        'eve/law.py.txt': LAW + b'# old',
    }

    submissions = found(tmp_path, files)

    assert [one.problem for one in submissions.values()] == [''] * 5
    assert list(submissions) == ['ada.py', 'bob.py', 'cid.py', 'dan.zip', 'eve']
    assert submissions['eve'].files['law.py'] == LAW


def test_a_script_is_not_lost_among_more_files_than_it_finds(tmp_path):
    files = {'law.py': LAW, **{f'data/{k}.csv': b'' for k in range(300)}}

    one, _ = found(tmp_path, {'ada.zip': archive(files), 'bob.py': LAW}).values()

    assert one.script == 'law.py'
    assert len(one.files) == 200


def test_copies_of_one_law_are_one(tmp_path):
    one, _ = found(tmp_path, {'ada/law.py': LAW, 'ada/law (1).py': LAW, 'bob.py': LAW}).values()

    assert one.problem == ''


@pytest.mark.parametrize(
    ('files', 'problem'),
    [
        ({'a.py': LAW, 'b.py': OTHER}, 'a.py and b.py both have a function control'),
        ({'a.py': b'', 'b.py': b''}, 'none of its 2 scripts has a function control'),
        ({'law.ipynb': b'{}'}, 'law.ipynb: it is not a Jupyter notebook, or it is damaged'),
        ({'law.zip': b'no zip file'}, 'law.zip is damaged'),
        ({'law.py': LAW, 'b.py': b'#' * 299_999}, 'have 300 kB, but at most 200 kB are allowed'),
        ({'law.py': LAW + b'#' * 2_000_000}, 'at most 200 kB are allowed'),
        ({'law.py': b'def control(:\n', 'gains.py': b''}, 'law.py, line 1: SyntaxError'),
        # several laws are named, and none is guessed
        (WITH_TEST | {'law_old.py': OTHER}, 'law.py and law_old.py both have'),
        (WITH_TEST | {'consensus.py': OTHER}, 'consensus.py and law.py both have'),
        ({'a.py': LAW, 'b.py': OTHER, 'v2/c.py': LAW}, 'a.py and b.py and v2/c.py all have'),
        ({'a.py': LAW, 'b.py': OTHER}, 'leave only the one to be marked in the submission'),
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
    (tmp_path / 'class/ada').mkdir(parents=True)
    (tmp_path / 'class/ada/secret.py').symlink_to(tmp_path / 'rubric.yaml')
    (tmp_path / 'class/dan.py').symlink_to(tmp_path / 'rubric.yaml')

    submissions = found(tmp_path, {'ada/law.py': LAW})

    assert submissions['ada'].files.keys() == {'law.py'}
    assert submissions['dan.py'].problem.startswith('dan.py is a symbolic link or no file')


BOMBS = {
    'bytes': (
        lambda: archive({f'{k}.py': bytes(1 << 20) for k in range(99)}, zipfile.ZIP_DEFLATED),
        '16 MB',
    ),
    'method': (lambda: archive({'a.py': bytes(1 << 20)}, zipfile.ZIP_BZIP2), 'unusual method'),
}
"""What test_sandbox.py does not have in PACKED."""


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


def test_a_class_has_a_limit_and_who_hands_in_the_most_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(submitted_files, '_MOST_OF_CLASS', 1 << 20)
    files = {f'{k}.py': LAW for k in range(9)}

    with pytest.raises(SetcmasError, match="more than 1 MB, most of it in 'big'; grade it in"):
        found(tmp_path, {**files, **{f'big/{k}.csv': b'' for k in range(300)}})


DEEP = {
    'deep': archive({f'{"a/" * 2250}law.py': LAW}),
    'long': archive({f'{"b" * 99}/' * 20 + 'law.py': LAW}),
    'name': archive({f'{"c" * 300}.py': LAW}),
}


@pytest.mark.parametrize('name', DEEP)
def test_a_path_that_no_disk_holds_costs_its_student_alone(tmp_path, name):
    (tmp_path / 'lone.zip').write_bytes(DEEP[name])

    submissions = found(tmp_path, {f'{name}.zip': DEEP[name], 'other.py': LAW})

    assert submissions['other.py'].problem == ''
    assert re.match(r'the path of \S+ is too long', submissions[f'{name}.zip'].problem)
    assert find_submissions(tmp_path / 'lone.zip', 'control')[0].problem


def test_a_damaged_file_of_a_class_costs_its_student_alone(tmp_path):
    content = bytearray(archive({'ada/law.py': os.urandom(999), 'bob/law.py': LAW}, 8))
    content[100:110] = bytes(10)
    (tmp_path / 'class.zip').write_bytes(content)

    ada, bob = find_submissions(tmp_path / 'class.zip', 'control')

    assert (ada.problem, bob.problem) == ('law.py is damaged or has a password', '')


def test_a_file_that_is_named_as_a_folder_is_left_out(tmp_path):
    one, _ = found(
        tmp_path,
        {'ada.zip': archive({'law.py': LAW, 'x': b'', 'x/y.py': b''}), 'bob.py': LAW},
    ).values()

    with one.unpacked() as script:
        assert script.read_bytes() == LAW


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
