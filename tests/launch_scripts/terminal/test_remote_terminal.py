import contextlib
import os
import pty
import subprocess
import sys
import threading
import tty

import pytest
from terminals import Terminal

from launch_scripts.terminal.remote_terminal import RemoteKeyboard
from setcmas_simu.errors import SetcmasError

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


@pytest.mark.parametrize('name', ['screen', 'mosh-server', 'tmux: server'])
def test_a_program_that_answers_in_its_place_is_refused(name, tmp_path):
    (tmp_path / name).symlink_to('/bin/sh')
    code = 'from launch_scripts.terminal.remote_terminal import RemoteKeyboard; RemoteKeyboard()'
    command = [str(tmp_path / name), '-c', f'"$0" -c "{code}"; true', sys.executable]

    done = subprocess.run(command, capture_output=True, text=True, check=False)

    assert f'outside of {name.partition(":")[0].removesuffix("-server")}' in done.stderr


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
