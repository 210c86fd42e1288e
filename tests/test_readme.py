"""What README tells is true: it is short, its examples work, its test command is the one of CI."""

import re
from pathlib import Path

from setcmas_ctrl.laws.script_loader import ALGORITHMS

ROOT = Path(__file__).parents[1]
README = (ROOT / 'README.md').read_text()
MOST_WORDS = 900


def code(language):
    return re.findall(rf'```{language}\n(.*?)```', README, re.DOTALL)


def test_it_is_short():
    assert len(README.split()) <= MOST_WORDS


def test_every_built_in_law_is_in_the_atlas():
    atlas = (ROOT / 'docs' / 'atlas.md').read_text()
    for path in sorted({ALGORITHMS.file(name) for name in ALGORITHMS.plugins()}):
        assert f'`{path.stem}`: ' in atlas, 'run docs/generators/atlas.py'


def test_the_first_two_commands_set_up_and_run():
    install, run = code('sh')[0].splitlines()

    assert install == "python3 -m venv .venv && . .venv/bin/activate && pip install -e '.[ros]'"
    assert run.startswith('setcmas run ')


def test_the_test_command_is_the_one_of_ci():
    install, run = code('sh')[-1].strip().split(' && ')
    ci = (ROOT / '.ci' / 'run').read_text()

    assert install.replace('pip install', 'pip install -q') in ci
    assert re.search(rf'^SETCMAS_SKIP_NOTHING=1 {run}$', ci, re.MULTILINE)
