import errno
import os
import signal
import time
from pathlib import Path
from unittest.mock import Mock

import psutil
import pytest
from processes import SETCMAS, TIMEOUT_S, Process, refuses, run_setcmas
from sandboxes import needs_sandbox

from launch_scripts.cli import main
from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_tools.grade.class_grading import KEPT, Grader
from setcmas_tools.submissions.sandbox import NoProcessError

LAW = ALGORITHMS.file('consensus').read_text()
SLOW = f"""{LAW}
law = control
def control(*args):
    import time
    time.sleep(0.003)
    return law(*args)
"""


@pytest.fixture
def grade(tmp_path, monkeypatch):
    """A function that grades scripts by name in this process; returns the exit status."""
    monkeypatch.chdir(tmp_path)

    def grade(*options, **scripts):
        for name, source in scripts.items():
            path = tmp_path / 'class' / f'{name}.py'
            path.parent.mkdir(exist_ok=True)
            path.write_text(source)
        return main(['grade', 'class', '-R', 'consensus', '--jobs', '1', *options])

    return grade


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['-R', 'consensus'], 'FOLDER is missing; name the folder of the submissions'),
        (['no', '-R', 'consensus'], "'no' cannot be read: No such file or directory"),
        (
            ['.', '-R', 'mine'],
            "there is no rubric 'mine'; give a file, or one of bearing_formation, consensus, ",
        ),
        (['no', '-R', 'no.yaml'], 'no.yaml'),
        (['.', '-R', 'consensus'], "'grades' would be in the folder of the submissions, '.'"),
    ],
)
def test_mistakes_are_reported_in_a_line(tmp_path, arguments, message):
    refuses('grade', *arguments, message=message, cwd=tmp_path)


def test_without_a_sandbox_nothing_is_run_unless_it_is_trusted(
    grade, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr('setcmas_tools.grade.class_grading.obstacle', lambda: 'no bwrap')

    assert grade(ada='open("touched", "w")\n' + LAW) == 2

    assert 'no sandbox: no bwrap; or add --trust to grade without' in capsys.readouterr().err
    assert not (tmp_path / 'touched').exists()


def test_corrections_in_the_folder_of_the_class_are_not_overlooked(grade, tmp_path, capsys):
    (tmp_path / 'class').mkdir()
    (tmp_path / 'class' / 'corrections.yaml').touch()

    assert grade('--trust', ada=LAW) == 2

    told = "move 'class/corrections.yaml' to 'grades', or name it with --corrections"
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ('error', 'status', 'message'),
    [(NoProcessError('no memory'), 2, 'no memory'), (KeyError(1), 1, 'setcmas failed')],
)
def test_what_is_no_fault_of_a_submission_has_an_exit_status(
    grade, tmp_path, monkeypatch, capsys, error, status, message
):
    monkeypatch.setattr(Grader, 'marks', Mock(side_effect=error))

    assert grade('--trust', ada=LAW) == status

    assert message in ''.join(capsys.readouterr())
    assert not list((tmp_path / 'grades' / KEPT).iterdir())


@pytest.mark.nightly
def test_grades_that_need_a_decision_are_counted_in_the_last_line(grade, tmp_path, capsys):
    (tmp_path / 'class/bob').mkdir(parents=True)
    scripts = {'ada': 'no = law\n', 'bob/a': LAW, 'bob/b': f'{LAW}# another\n'}
    assert grade('--trust', **scripts) == 0

    *_, last = capsys.readouterr().out.splitlines()
    assert last.startswith('1 submission without a grade: the remarks say why')
    rows = (tmp_path / 'grades' / 'grades.csv').read_text().splitlines()
    assert rows[1].startswith('ada,,,ada.py,ada.py,0,10,')
    assert rows[2].startswith('bob,,,bob,,,10,a.py and b.py both')

    (tmp_path / 'grades' / 'corrections.yaml').write_text(
        'author: Ann\ndate: 2026-11-22\n'
        'corrections: [{student: bob, total: 3, reason: seen by hand}]\n'
    )
    assert grade('--trust') == 0
    assert 'bob,,,bob,,3,10,' in (tmp_path / 'grades' / 'grades.csv').read_text()


@pytest.mark.nightly
def test_after_a_full_disk_the_same_command_goes_on(grade, tmp_path, monkeypatch, capsys):
    assert grade('--trust', ada='no = law\n', bob='') == 0
    grades = tmp_path / 'grades'
    before = {path: path.read_bytes() for path in grades.rglob('*') if path.is_file()}
    write, left = Path.write_text, iter(range(3))

    def on_a_small_disk(path, *args, **known):
        if next(left, None) is None:
            write(path, 'half')
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, *args, **known)

    (tmp_path / 'class' / 'bob.py').unlink()
    with monkeypatch.context() as patch:
        patch.setattr(Path, 'write_text', on_a_small_disk)
        assert grade('--trust') == 2
    assert "'grades' cannot be written: No space left on device" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in before if path.is_file()}.items() <= before.items()

    assert grade('--trust') == 0
    assert not (grades / 'students' / 'bob.html').exists()
    assert 'bob' not in (grades / 'grades.csv').read_text()
    assert 'bob' in (grades / 'grades.csv.bak').read_text()


@pytest.mark.nightly
@needs_sandbox
@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGKILL])
def test_a_grading_that_is_killed_leaves_no_process_and_goes_on(tmp_path, number):
    (tmp_path / 'class').mkdir()
    for name, source in {'a': LAW, 'b': SLOW, 'c': SLOW}.items():
        (tmp_path / 'class' / f'{name}.py').write_text(source)
    command = ['grade', 'class', '-R', 'consensus', '-o', 'grades', '--jobs', '2']
    process = Process([*SETCMAS, *command], tmp_path / 'log', tmp_path, os.environ)
    while not list((tmp_path / 'grades' / KEPT).glob('*.json')):
        assert process.popen.poll() is None, process.output()
        time.sleep(0.05)
    started = psutil.Process(process.pid).children(recursive=True)
    process.end(number)

    assert not psutil.wait_procs(started, timeout=TIMEOUT_S)[1]
    done = {file: file.stat().st_mtime_ns for file in (tmp_path / 'grades' / KEPT).iterdir()}
    result = run_setcmas(*command, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert all(
        file.stat().st_mtime_ns == at for file, at in done.items() if file.suffix == '.json'
    )
    assert len(list((tmp_path / 'grades' / KEPT).glob('*.json'))) == 3
