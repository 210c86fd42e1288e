import io
import os
import pty
import subprocess
import sys

import pytest

from launch_scripts.terminal.terminal import LineBuffer, StartKey


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
from launch_scripts.terminal.terminal import kept_terminal
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


def fed(*chunks, prefix=''):
    buffer = LineBuffer(prefix, io.StringIO())
    return [line for chunk in chunks for line in buffer.feed(chunk)]


def test_lines_come_out_whole_however_they_arrive():
    assert fed(b'on', b'e\ntw', b'o\nthree') == ['one', 'two']
    assert fed(b'one\ntwo', b'') == ['one', 'two']


def test_every_line_has_its_prefix():
    assert fed(b'one\n\ntwo\r\n', prefix='[simu] ') == ['[simu] one', '[simu] ', '[simu] two']


def test_severities_of_the_logger_become_words():
    lines = fed(b'INFO|hello\nWARN|take care\nERROR|no\nother|thing\n')

    assert lines == ['hello', 'warning: take care', 'error: no', 'other|thing']


def test_bytes_that_are_no_text_and_endless_lines_do_no_harm():
    assert fed(b'\xff\xfe\n') == ['\ufffd\ufffd']
    assert sum(map(len, fed(b'x' * 50_000))) == 50_000
