"""What docs/control_scripts.md tells is true: its scripts run, its commands are accepted."""

import re
import shlex
from pathlib import Path

import pytest

from launch_scripts.cli import build_parser
from setcmas_tools import simulate

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / 'docs' / 'control_scripts.md').read_text()
COMMANDS = [
    shlex.split(line)[1:]
    for block in re.findall(r'```sh\n(.*?)```', PAGE, re.DOTALL)
    for line in block.splitlines()
]
SCRIPTS = re.findall(r'```python\n(.*?)```', PAGE, re.DOTALL)


@pytest.mark.parametrize('words', COMMANDS, ids=' '.join)
def test_every_command_is_accepted(words):
    args, unknown = build_parser(words[0]).parse_known_args(words)

    assert args.verb == words[0]
    assert not unknown


@pytest.mark.parametrize('text', SCRIPTS)
def test_every_script_runs(tmp_path, text):
    path = tmp_path / 'law.py'
    path.write_text(text)
    said = []

    simulate(path, nb_robots=3, duration=5, say=said.append)

    assert len(SCRIPTS) == 3
    assert said == []


@pytest.mark.parametrize(
    'message',
    [
        'has no function ',
        'does not take four arguments',
        'control returned None',
        'a value that is not finite',
        'control has not returned',
        'it is at ',
        ' occurred ',
        'works again after ',
    ],
)
def test_messages_are_those_of_the_program(message):
    sources = (ROOT / 'setcmas_ctrl' / 'setcmas_ctrl').glob('*.py')

    assert message.strip() in PAGE
    assert any(message in source.read_text() for source in sources)


def test_pictures_are_there():
    pictures = re.findall(r'!\[.*?\]\((.*?)\)', PAGE)

    assert len(pictures) == 2
    for picture in pictures:
        assert (ROOT / 'docs' / picture).is_file()
    assert 'tests/pictures/drawing_functions.py' in PAGE
    assert (ROOT / 'tests' / 'pictures' / 'drawing_functions.py').is_file()
