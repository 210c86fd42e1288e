import os
import re
import subprocess
import sys

import pytest
from processes import run_here

from launch_scripts.cli import VERBS, spelled
from setcmas_simu import __version__


def test_options_and_verbs_may_be_spelled_with_either_dash():
    typed = ['bag-to-csv', 'my_bag', '--nb_robots=8', '--cmd_timeout', '0_5', '-o', 'a_b']

    assert spelled(typed) == [
        'bag_to_csv',
        'my_bag',
        '--nb-robots=8',
        '--cmd-timeout',
        '0_5',
        '-o',
        'a_b',
    ]


def test_without_a_verb_the_help_is_shown():
    result = run_here()

    assert result.returncode == 0
    for verb in VERBS:
        assert verb in result.stdout


def test_version():
    assert run_here('--version').stdout == f'setcmas {__version__}\n'


@pytest.mark.parametrize('arguments', [['list'], ['run', '--help'], ['--version']])
def test_a_reader_that_has_read_enough_hears_nothing_of_it(arguments):
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, '-m', 'launch_scripts.cli', *arguments]
    environment = {name: os.environ[name] for name in os.environ.keys() - {'PYTHONUNBUFFERED'}}
    done = subprocess.run(
        command, stdout=writing, stderr=subprocess.PIPE, text=True, env=environment
    )
    os.close(writing)

    assert (done.returncode, done.stderr) == (0, '')


@pytest.mark.parametrize('verb', sorted(VERBS))
def test_every_verb_explains_itself_with_an_example(verb):
    result = run_here(verb, '--help')

    assert result.returncode == 0
    assert verb in result.stdout
    assert 'examples:' in result.stdout.lower()


def test_help_imports_neither_ros_nor_matplotlib_nor_numpy_and_looks_no_plugin_up():
    code = (
        'import sys\nfrom launch_scripts.cli import main\n'
        'try:\n    main(["--help"])\nexcept SystemExit:\n    pass\n'
        'heavy = ("rclpy", "matplotlib", "numpy", "rosbags", "importlib.metadata")\n'
        'print([m for m in heavy if m in sys.modules])'
    )
    result = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)

    assert result.stdout.endswith('[]\n')


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('simi',), "unknown verb 'simi'.*did you mean simu"),
        (('simu', '--limit', 'burger'), "unknown argument '--limit'; did you mean --limits"),
        (('simu', '--nb-robots', 'x'), "--nb-robots is 'x'; it must be a whole number from 1"),
        (
            ('simu', '--limits', 'segway'),
            "--limits is 'segway'; it must be ideal, burger",
        ),
        (('simu', '--nb-robots', '2', '--robots', '3'), 'robots 1 to 2'),
        (('ctrl',), 'there is no control law: add --algo'),
        (('ctrl', '--algo', 'consensu'), 'did you mean consensus'),
        (('ctrl', '--algo', 'consensus', '--vnom', '0'), '--vnom is 0; it must be above 0 m/s'),
        (('ctrl', '--algo', 'consensus', '--set', 'K'), "invalid setting 'K'"),
        (
            ('ctrl', '--algo', 'consensus', '--set', 'k=1'),
            "no module-level name 'k'.*did you mean K",
        ),
        (('offline', '--algo', 'consensus', '--watch'), "unknown argument '--watch'"),
        (('bag_to_csv', 'no_bag'), 'no_bag'),
        (('csv_to_plot', 'no_run'), 'no_run'),
    ],
)
def test_mistakes_are_reported_in_one_line_with_status_2(arguments, message, tmp_path):
    result = run_here(*arguments, cwd=tmp_path)

    assert result.returncode == 2
    assert len(result.stderr.strip().splitlines()) == 1
    assert re.search(message, result.stderr)
    assert list(tmp_path.iterdir()) == []


def test_list_shows_built_in_laws_and_those_of_the_folder(tmp_path):
    (tmp_path / 'mine.py').write_text(
        '"""Turns round.\n\nMore."""\ndef control(a, b, c, d): ...\n'
    )
    (tmp_path / 'helper.py').write_text('x = 1\n')
    (tmp_path / 'broken.py').write_text('def control(:\n')

    lines = run_here('list', cwd=tmp_path).stdout.splitlines()

    assert any('nav_wp' in line and 'wp_nav' in line for line in lines)
    assert any(line.split() == ['mine', 'Turns', 'round.'] for line in lines)
    assert 'exercises, for --algo with --exercise:' in lines
    assert any(line.startswith('  ctc ') for line in lines)
    assert any('broken' in line and 'cannot be read' in line for line in lines)
    assert not any('helper' in line for line in lines)


def test_completion_of_verbs_options_and_values(tmp_path):
    def complete(line):
        command = f"{sys.executable} -c 'from launch_scripts.cli import main; main()' 8>&1 9>&2"
        result = subprocess.run(
            ['bash', '-c', command],
            env={
                **os.environ,
                '_ARGCOMPLETE': '1',
                '_ARGCOMPLETE_IFS': '\n',
                'COMP_LINE': line,
                'COMP_POINT': str(len(line)),
                'COMP_TYPE': '9',
            },
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
        return [word.strip() for word in result.stdout.splitlines()]

    assert complete('setcmas bag') == ['bag_to_csv']
    assert '--nb-robots' in complete('setcmas simu --nb')
    assert complete('setcmas simu --limits bur') == ['burger']


def test_ctrl_c_while_modules_are_loaded_prints_nothing():
    code = (
        'import sys\n'
        'class Interrupted:\n'
        '    def find_spec(self, name, *_):\n'
        '        if name == "setcmas_simu.errors":\n'
        '            raise KeyboardInterrupt\n'
        'sys.meta_path.insert(0, Interrupted())\n'
        'import launch_scripts.cli'
    )
    result = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)

    assert (result.returncode, result.stdout, result.stderr) == (130, '', '')
