import os
import pty
import subprocess
import sys

import pytest

from launch_scripts.terminal.keyboard import StartKey


def starts(batches, held=False):
    """Return when batches of keys, 0.1 s from each other, start robots."""
    key = StartKey(held)
    return [step for step, keys in enumerate(batches) if key.pressed(keys, step / 10)]


@pytest.mark.parametrize('key', ['s', 'S'])
def test_the_key_alone_starts(key):
    assert len(starts([key, *[''] * 20])) == 1


@pytest.mark.parametrize(
    'batches',
    [
        ['ls\n'],
        ['ss'],
        ['l', 's', '\n'],
        ['s', 'o', 'u'],
        ['hello ', 's'],
        ['\x1b[200~s\x1b[201~'],
        ['', 's', ' '],
    ],
)
def test_words_that_are_typed_or_pasted_do_not(batches):
    assert starts([*batches, *[''] * 20]) == []
    assert starts([*batches, *[''] * 20, 's', *[''] * 5]) != []


def test_a_key_to_hold_is_reported_each_time():
    assert starts(['s', '', 'ss', 's', '', 'l', 's'], held=True) == [0, 2, 3]


CODE = """
import os
from launch_scripts.terminal.keyboard import kept_terminal
with kept_terminal():
    os.system('stty -echo raw')
"""


def test_a_terminal_that_a_script_has_changed_is_given_back():
    import termios

    terminal, inner = pty.openpty()
    before = termios.tcgetattr(inner)

    subprocess.run([sys.executable, '-c', CODE], stdin=inner, check=True)

    assert termios.tcgetattr(inner) == before
    os.close(terminal)
    os.close(inner)
