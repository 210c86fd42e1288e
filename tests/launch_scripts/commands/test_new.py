import re

import pytest
from processes import refuses, run_here, run_setcmas

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_tools import Scenario, simulate


def test_the_new_script_runs_by_the_command_that_is_printed(tmp_path):
    result = run_here('new', 'my_law', cwd=tmp_path)
    printed = result.stdout.splitlines()[-1].split()

    assert result.returncode == 0
    assert printed == ['setcmas', 'run', '--algo', 'my_law', '--nb-robots', '5']
    offline = run_here(
        'offline', '--no-plots', *printed[2:], '--duration', '2', '-o', 'out', cwd=tmp_path
    )
    assert offline.returncode == 0, offline.stderr
    assert 'tb3_5: I start at (0.0, 5.0) m' in offline.stdout
    assert 'my_law  My control law' in run_here('list', cwd=tmp_path).stdout


def test_the_new_si_to_uni_runs_by_the_command_that_is_printed(tmp_path):
    result = run_here('new', 'my_driver', '--si-to-uni', cwd=tmp_path)
    printed = result.stdout.splitlines()[-1].split()

    assert printed == ['setcmas', 'run', '--algo', 'nav_wp', '--si-to-uni', 'my_driver']
    offline = run_here(
        'offline', '--no-plots', *printed[2:], '--duration', '2', '-o', 'out', cwd=tmp_path
    )
    assert offline.returncode == 0, offline.stderr
    again = run_here('offline', '--no-plots', '--from', 'out', '-o', 'again', cwd=tmp_path)
    assert 'identical to out' in again.stdout


@pytest.mark.parametrize(
    ('arguments', 'source', 'command'),
    [
        ('mine --from consensus', ALGORITHMS.file('consensus'), '--algo mine'),
        ('mine.py --from nav-wp', ALGORITHMS.file('nav_wp'), '--algo mine'),
        ('mine --from consensus --exercise', EXERCISES.file('consensus'), '--algo mine'),
        ('mine --from ctc --exercise', EXERCISES.file('ctc'), '--event-triggered --ctc mine'),
        ('mine --from point_ahead --exercise', EXERCISES.file('point_ahead'), '--si-to-uni mine'),
        ('nav_wp --exercise', EXERCISES.file('nav_wp'), '--algo nav_wp'),  # it keeps its name
    ],
)
def test_a_law_or_an_exercise_is_copied(tmp_path, arguments, source, command):
    (tmp_path / 'wp_nav.py').touch()
    result = run_here('new', *arguments.split(), cwd=tmp_path)

    assert command in result.stdout
    name = arguments.split()[0].removesuffix('.py')
    assert (tmp_path / f'{name}.py').read_bytes() == source.read_bytes()


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('taken',), "'taken.py' already exists"),
        (('my-law',), 'letters, digits and _, such as my_law'),
        (('numpy',), "'numpy' is a module"),
        (('class',), "'class' cannot be the name of a script"),
        (('../law',), 'cannot be the name of a script'),
        (('unused', '--from', 'consensu'), 'did you mean consensus'),
        (('unused', '--robot', '--si-to-uni'), 'not allowed with argument --robot'),
        (
            ('unused', '--exercise'),
            "unknown exercise 'unused'; it must be one of bearing_formation, ",
        ),
    ],
)
def test_mistakes_are_reported_in_one_line_and_nothing_is_written(tmp_path, arguments, message):
    (tmp_path / 'taken.py').write_text('mine')

    refuses('new', *arguments, message=message, cwd=tmp_path)
    assert (tmp_path / 'taken.py').read_text() == 'mine'
    assert len(list(tmp_path.iterdir())) == 1


def test_a_script_that_hides_a_built_in_law_is_reported_when_written_and_when_run(tmp_path):
    # In a process of its own: here, a law that another test loaded may be on Python's path.
    written = run_setcmas('new', 'consensus', cwd=tmp_path)
    run = run_here('offline', '--no-plots', '--algo', 'consensus', '--duration', '1', cwd=tmp_path)

    assert '--algo consensus now runs this file instead of the built-in law' in written.stdout
    assert run.returncode == 0
    assert '--algo consensus runs consensus.py in this folder' in run.stderr


@pytest.mark.parametrize('number', range(1, 7))
def test_a_session_is_a_folder_with_exercise_scenarios_and_questions(tmp_path, number):
    run_here('new', '--session', str(number), cwd=tmp_path)
    folder = tmp_path / f'session_{number}'
    page, asked = ((folder / name).read_text() for name in ('session.md', 'questions.md'))

    assert page.startswith(f'# Session {number}: ')
    numbers = re.findall(rf'\*\*(Q{number}\.\d+)\*\*', asked)
    assert numbers == [f'Q{number}.{i}' for i in range(1, len(numbers) + 1)] != []
    assert page.count(f'**Q{number}.') == len(numbers)
    for path in folder.glob('*.py'):
        assert path.name in page
    for path in folder.glob('*.yaml'):
        if 'segments' not in path.read_text():  # a graph
            assert simulate(Scenario.load(path), duration=1.0, warn=print).t[-1] == 1.0
        assert path.name in page


def test_without_ros_there_is_setcmas_offline(tmp_path):
    (tmp_path / 'sitecustomize.py').write_text("import sys\nsys.modules['rclpy'] = None\n")
    run = run_setcmas('run', '--algo', 'consensus', cwd=tmp_path, PYTHONPATH=str(tmp_path))
    new = run_setcmas('new', 'my_law', cwd=tmp_path, PYTHONPATH=str(tmp_path))

    assert run.returncode == 2
    assert "(rclpy): 'setcmas offline' takes the same options and needs no ROS" in run.stderr
    assert 'setcmas offline --algo my_law --nb-robots 5' in new.stdout
