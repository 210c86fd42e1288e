import contextlib
import os
import pty
import subprocess
import sys
import threading
import tty

import pytest
from terminals import Terminal

from launch_scripts.terminal import LineBuffer, RemoteKeyboard, StartKey
from setcmas_simu.errors import SetcmasError


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


def fed(*chunks, prefix=''):
    buffer = LineBuffer(prefix)
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


SSH = '192.0.2.2 50000 192.0.2.1 22'


class Answering:
    """The person's side of a terminal: answers each question while `answers` is set."""

    def __init__(self, master):
        self.answers = threading.Event()
        self.master = master
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        with contextlib.suppress(OSError):  # the terminal was closed
            while data := os.read(self.master, 4096):
                for _ in range(data.count(b'\x1b[5n')):
                    self.answers.wait()
                    os.write(self.master, b'\x1b[0n')


@pytest.fixture
def side(monkeypatch):
    master, slave = pty.openpty()
    tty.setraw(slave)
    with os.fdopen(slave) as stdin:
        monkeypatch.setattr('sys.stdin', stdin)
        yield Answering(master)


def polled(keyboard, until):
    """Return all keys until a condition holds."""
    keys = keyboard.pressed()
    while not until():
        keys += keyboard.pressed()
    return keys


def test_a_terminal_that_answers_is_attended_and_its_answers_are_no_keys(side):
    side.answers.set()
    keyboard = RemoteKeyboard()

    os.write(side.master, b's')
    keys = polled(keyboard, lambda: keyboard.is_attended)
    keys += polled(keyboard, lambda: not keyboard.is_attended)
    keys += polled(keyboard, lambda: keyboard.is_attended)

    assert keys == 's'
    assert not keyboard.only_stops


def test_keys_that_were_typed_while_it_did_not_answer_only_stop(side):
    side.answers.set()
    keyboard = RemoteKeyboard()
    polled(keyboard, lambda: keyboard.is_attended)
    side.answers.clear()
    polled(keyboard, lambda: keyboard.only_stops)
    assert not keyboard.is_attended

    os.write(side.master, b's')
    side.answers.set()

    assert 's' in polled(keyboard, lambda: keyboard.is_attended)
    assert keyboard.only_stops
    polled(keyboard, lambda: not keyboard.only_stops)


def test_a_terminal_that_does_not_answer_is_refused(side):
    with pytest.raises(SetcmasError, match=r'the other end of ssh does not answer.*--hold'):
        RemoteKeyboard()


@pytest.mark.parametrize(
    ('name', 'emulated', 'refused'),
    [
        ('sshd', False, 'the other end of ssh does not answer'),
        ('tmux: server', False, 'run setcmas outside of tmux'),
        ('mosh-server', False, 'run setcmas outside of mosh'),
        ('tmux: server', True, ''),
    ],
)
def test_a_person_who_may_be_elsewhere_is_found_by_the_parents(name, emulated, refused, tmp_path):
    (tmp_path / name).symlink_to('/bin/sh')
    code = (
        'from launch_scripts.terminal import RemoteKeyboard, open_operator_keyboard as opened\n'
        f'with opened(False, {emulated}) as keys: print(type(keys) is RemoteKeyboard)'
    )
    command = [str(tmp_path / name), '-c', '"$0" -c "$1"; true', sys.executable, code]
    master, slave = pty.openpty()

    done = subprocess.run(command, stdin=slave, capture_output=True, text=True, env=LOCAL)

    os.close(master), os.close(slave)
    assert refused in done.stderr
    assert bool(refused) == ('--hold' in done.stderr) == (done.stdout != 'False\n')


LOCAL = {name: value for name, value in os.environ.items() if not name.startswith('SSH_')}


class SshTerminal(Terminal):
    """A terminal at the other end of ssh, which answers whenever it is read."""

    answers = True

    @staticmethod
    def _environment():
        return {**Terminal._environment(), 'SSH_CONNECTION': SSH}

    def read(self):
        text = super().read()
        if self.answers:
            self.press('\x1b[0n')
        return text


@pytest.mark.nightly
@pytest.mark.ros
def test_robots_stop_when_the_connection_hangs_and_a_late_key_starts_nothing(domain):
    terminal = SshTerminal('expe', '--emulate', '--algo', 'nav_wp', '--no-joystick')
    try:
        terminal.start_robots()
        terminal.answers = False
        terminal.wait_for('paused: the terminal does not answer')
        terminal.press('s')
        terminal.answers = True
        terminal.wait_for('not started: over ssh')
        terminal.start_robots()
        terminal.press('q')
        assert terminal.wait() == 0
    finally:
        terminal.close()
