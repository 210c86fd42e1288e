"""What docs/control_scripts.md tells is true: its messages are those of the program."""

import re
from pathlib import Path

import pytest

from setcmas_tools import simulate

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / 'docs' / 'control_scripts.md').read_text()


@pytest.mark.parametrize('message', [' has not returned', 'it is at ', 'works again after '])
def test_messages_are_those_of_the_program(message):
    sources = (one for name in ('simu', 'ctrl') for one in ROOT.glob(f'setcmas_{name}/**/*.py'))

    assert message.strip() in PAGE
    assert any(message in source.read_text() for source in sources)


def test_the_predictions_are_those_of_the_run():
    options = r'--algo (\w+) --nb-robots (\d+) --graph (\w+) --duration (\d+)'
    law, robots, graph, duration = re.search(options, PAGE).groups()
    metrics = simulate(law, int(robots), float(duration), graph=graph).metrics()

    assert '\n'.join(metrics['prediction'].lines()) in PAGE


def test_pictures_are_there():
    pictures = re.findall(r'!\[.*?\]\((.*?)\)', PAGE)

    assert len(pictures) == 2
    for picture in pictures:
        assert (ROOT / 'docs' / picture).is_file()
    assert (ROOT / 'docs/generators/drawing_functions.py').is_file()
