import os
import signal
import textwrap
from pathlib import Path

import pytest
from control_functions import load_control

from setcmas_ctrl import algorithms
from setcmas_ctrl.laws.script_loader import ALGORITHMS, compile_script, plain_values
from setcmas_ctrl.laws.script_search import find_script
from setcmas_simu.errors import SetcmasError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def script(folder, text, name='law.py'):
    path = folder / name
    path.write_text(textwrap.dedent(text))
    return path


CONTROL = 'def control(robotNo, nbRobots, poses, t):\n    return 0, 0\n'


def test_the_built_in_laws_are_found_by_name(folder):
    paths = {find_script(name) for name, plugin in ALGORITHMS.plugins().items() if plugin.built_in}

    laws = Path(algorithms.__file__).parent.glob('[!_]*.py')
    assert sorted(path.stem for path in paths) == sorted(path.stem for path in laws)


@pytest.mark.parametrize('name', ['nav_wp', 'wp_nav', 'nav-wp'])
def test_nav_wp_has_its_ros_1_name_too(name, folder):
    assert find_script(name) == ALGORITHMS.file('nav_wp')


def test_a_script_in_the_current_folder_goes_before_a_built_in_and_a_path_before_all(folder):
    (folder / 'elsewhere').mkdir()
    path = script(folder / 'elsewhere', CONTROL, 'consensus.py')

    assert script(folder, CONTROL, 'consensus.py') == find_script('consensus')
    assert find_script('elsewhere/consensus.py') == path


def test_a_missing_script_is_reported_with_the_nearest_names(folder):
    script(folder, CONTROL, 'my_law.py')
    script(folder, 'def ctc(pos, last_pos, t):\n    return True', 'my_lave.py')  # not offered

    with pytest.raises(SetcmasError, match=r"'my_lav' of --algo .*; did you mean my_law\?") as e:
        find_script('my_lav')
    assert 'consensus' in str(e.value)
    assert '\n' not in str(e.value)


@pytest.mark.parametrize(
    ('text', 'encoding', 'message'),
    [
        (CONTROL, 'utf-16', 'law.py has an invalid or missing encoding declaration; save it as'),
        (
            f'{CONTROL}# é\n',
            'latin-1',
            r'law.py is not encoded in utf-8 \(byte 0xe9\); save it as',
        ),
        (f'# coding: lattin-1\n{CONTROL}', 'utf-8', 'law.py has an unknown encoding; save it as'),
    ],
)
def test_a_script_that_is_no_text_of_a_known_encoding_is_reported(folder, text, encoding, message):
    path = folder / 'law.py'
    path.write_text(text, encoding=encoding)

    with pytest.raises(SetcmasError, match=message):
        compile_script(path)


@pytest.mark.parametrize(
    'text',
    [
        CONTROL,
        'def control(a, b, c, d):\n\treturn [0, 0]\n',
        'def control(*arguments):\n    return 0, 0\n',
        'def control(a, b, c, d, e=1):\n    return 0, 0\n',
        'control = lambda i, n, p, t: (0, 0)\n',
        'class C:\n    def __call__(self, i, n, p, t):\n        return 0, 0\ncontrol = C()\n',
        'from helper_of_law import control\n',
    ],
)
def test_any_callable_with_four_positional_arguments_will_do(folder, text):
    script(folder, CONTROL, 'helper_of_law.py')
    control = load_control(script(folder, text), 1)

    assert tuple(control(1, 1, None, 0.0)) == (0, 0)


def test_a_failure_for_one_robot_while_loading_names_the_robot(folder):
    path = script(folder, f"if __name__.endswith('2'):\n    1 / 0\n{CONTROL}")
    load_control(path, 1)

    with pytest.raises(SetcmasError, match=r'^tb3_2: law\.py, line 2: ZeroDivisionError'):
        load_control(path, 2)


def test_a_keyboard_interrupt_of_the_script_is_a_failure_where_ctrl_c_is_handled(
    folder, monkeypatch
):
    path = script(folder, f'raise KeyboardInterrupt\n{CONTROL}')
    monkeypatch.setattr(signal, 'getsignal', lambda _: signal.SIG_IGN)
    with pytest.raises(SetcmasError, match='KeyboardInterrupt'):
        load_control(path, 1)


@pytest.mark.parametrize(
    ('name', 'message'),
    [
        ('folder', 'not found'),
        ('pipe', 'not found'),
        ('x' * 5000, 'not found'),
        ('law.ipynb', r'is a notebook; start its cell with `%%writefile law\.py`'),
    ],
)
def test_files_that_are_no_scripts_are_reported_as_what_they_are(tmp_path, name, message):
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'law.ipynb').write_text('{}')
    os.mkfifo(tmp_path / 'pipe')

    with pytest.raises(SetcmasError, match=message):
        find_script(str(tmp_path / name))


@pytest.mark.parametrize(
    ('source', 'advice'),
    [('from .helper import x', 'without the dot'), ('raise EOFError', 'scripts have no input')],
)
def test_advice_for_what_scripts_cannot_do(folder, source, advice):
    with pytest.raises(SetcmasError, match=advice):
        load_control(script(folder, f'{source}\n{CONTROL}'), 1)


def test_odd_syntax_is_reported_once_for_all_robots(folder, capsys):
    path = script(folder, f'TEXT = 1 is 1\n{CONTROL}')
    for robot in (1, 2, 3):
        load_control(path, robot)

    shown = capsys.readouterr().err
    assert shown.startswith('warning: law.py, line 1: ')
    assert shown.count('\n') == 1


def test_plain_values_are_read_without_running_the_script(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('raise RuntimeError\nWPL = [[1, 2]]\nN = len(WPL)\nD: float = 2\n')

    assert plain_values(path) == {'WPL': [[1, 2]], 'D': 2}


@pytest.mark.parametrize('value', ['{[1]: 2}', '{{}}'])
def test_values_that_python_cannot_make_are_left_out(tmp_path, value):
    (tmp_path / 'law.py').write_text(f'K = 1\nx = {value}\n')

    assert plain_values(tmp_path / 'law.py') == {'K': 1}


def test_a_script_that_is_nested_too_deeply_is_reported(tmp_path):
    (tmp_path / 'law.py').write_text(f'x = {"-" * 100_000}1')

    with pytest.raises(SetcmasError, match=r'law\.py: an expression is nested too deeply'):
        plain_values(tmp_path / 'law.py')
