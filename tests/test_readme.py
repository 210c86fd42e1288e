"""What README tells is true: its tables, its examples, its test command is the one of CI."""

import re
from pathlib import Path

import pytest

from launch_scripts.cli import VERBS, build_parser
from setcmas_ctrl.scripts.loader import builtin_folder, load_control, scripts_in

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text()


def code(language):
    return re.findall(rf'```{language}\n(.*?)```', README, re.DOTALL)


@pytest.mark.parametrize('verb', VERBS)
def test_the_options_in_the_table_of_commands_exist(verb, capsys):
    row = re.search(rf'^\| `setcmas {verb}\b.*$', README, re.MULTILINE)
    assert row
    with pytest.raises(SystemExit):
        build_parser(verb).parse_args([verb, '--help'])
    told = set(re.findall(r'(?<!\S)\[?(--[a-z-]+)', capsys.readouterr().out))

    assert set(re.findall(r'`(--[a-z-]+)', row.group())) <= told


def test_every_verb_and_every_built_in_law_is_told():
    for name in [*VERBS, *[path.stem for path in scripts_in(builtin_folder())]]:
        assert name in README


def test_the_test_command_is_the_one_of_ci():
    install, run = code('sh')[-1].strip().split(' && ')
    ci = (ROOT / '.ci' / 'run').read_text()

    assert install.replace('pip install', 'pip install -q') in ci
    assert re.search(rf'^SETCMAS_SKIP_NOTHING=1 {run}$', ci, re.MULTILINE)


def test_no_placeholder_is_left():
    assert not re.search(r'\b(FIGURES|TODO|FIXME|XXX)\b', README)


def test_the_notebook_example_works(capsys):
    exec(code('python')[1], {})

    assert capsys.readouterr().out.startswith('[[')


def test_the_control_law_works(tmp_path):
    import numpy as np

    path = tmp_path / 'my_law.py'
    path.write_text(code('python')[0])

    assert load_control(path, 1)(1, 2, np.array([[0.0, 2.0], [0.0, 4.0], [0, 0]]), 0.0) == (0.5, 1)
