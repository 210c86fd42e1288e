"""What docs/control_scripts.md tells is true: its messages are those of the program."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / 'docs' / 'control_scripts.md').read_text()


@pytest.mark.parametrize(
    'message',
    [
        'has no function ',
        'does not take four arguments',
        'control returned None',
        'a value that is not finite',
        ' has not returned',
        'it is at ',
        'works again after ',
    ],
)
def test_messages_are_those_of_the_program(message):
    sources = (ROOT / 'setcmas_ctrl' / 'setcmas_ctrl').rglob('*.py')

    assert message.strip() in PAGE
    assert any(message in source.read_text() for source in sources)


def test_pictures_are_there():
    pictures = re.findall(r'!\[.*?\]\((.*?)\)', PAGE)

    assert len(pictures) == 2
    for picture in pictures:
        assert (ROOT / 'docs' / picture).is_file()
    assert (ROOT / 'docs/generators/drawing_functions.py').is_file()
