"""Terminals of the tests' own, for commands that read keys."""

import codecs
import contextlib
import fcntl
import os
import pty
import re
import struct
import subprocess
import termios
import time

import psutil
from processes import SETCMAS, TIMEOUT_S

from setcmas_expe.pause.press_judge import REACTION_S

ESCAPE = re.compile('\x1b\\[[0-9;?]*[A-Za-z]')


def pressed_until(press, condition):
    """Return a condition that holds when another one does, and calls `press` until then.

    Again and again: a press that comes too early, or while a busy machine delays processes, is
    refused. Sooner, two presses count as one.
    """
    next_press = 0.0

    def holds():
        nonlocal next_press
        if condition():
            return True
        if time.monotonic() >= next_press:
            next_press = time.monotonic() + 1.5 * REACTION_S
            press()
        return False

    return holds


class Terminal:
    """A terminal of one's own with a setcmas command in it."""

    def __init__(self, *arguments):
        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack('4H', 30, 110, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.text = self._written = ''
        self._decoder = codecs.getincrementaldecoder('utf-8')()
        self.process = subprocess.Popen(
            [*SETCMAS, *arguments],
            stdin=self.slave,
            stdout=self.slave,
            stderr=self.slave,
            env=self._environment(),
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )
        os.set_blocking(self.master, False)

    @staticmethod
    def _environment():
        """Return the environment of a terminal whose size is its own, not that of the tests'."""
        kept = {name: value for name, value in os.environ.items() if name != 'COLUMNS'}
        return {**kept, 'TERM': 'xterm-256color'}

    def read(self):
        """Take all that has been written: what nobody reads holds up the news after it."""
        with contextlib.suppress(OSError):  # that there is no more, or that the command has ended
            while data := os.read(self.master, 65536):
                self._written += self._decoder.decode(data)
        # An escape sequence may have come in part.
        whole = re.sub(r'\x1b[^A-Za-z]*\Z', '', self._written)
        self.text += ESCAPE.sub('', whole)
        self._written = self._written[len(whole) :]
        return self.text

    def wait_for(self, pattern, timeout=TIMEOUT_S):
        deadline = time.monotonic() + timeout
        while not (found := re.search(pattern, self.read(), re.DOTALL)):
            assert time.monotonic() < deadline, self.text
            time.sleep(0.02)
        self.text = self.text[found.end() :]
        return found

    def press(self, key):
        os.write(self.master, key.encode())

    def start_robots(self, started=r'started: by s'):
        """Press s until the robots have started; where they go already it does nothing.

        Args:
            started: Pattern that the terminal then shows, or a function that returns whether.
        """
        self.press_until(started, 's')

    def press_until(self, shown, key):
        """Press a key until the terminal shows a pattern, or a function returns true."""

        def is_shown():
            self.read()
            return shown() if callable(shown) else re.search(shown, self.text, re.DOTALL)

        holds = pressed_until(lambda: self.press(key), is_shown)
        deadline = time.monotonic() + TIMEOUT_S
        while not holds():
            assert time.monotonic() < deadline, self.text
            time.sleep(0.02)

    def wait(self, timeout=TIMEOUT_S):
        deadline = time.monotonic() + timeout
        while self.process.poll() is None:
            assert time.monotonic() < deadline, self.text
            self.read()
            time.sleep(0.02)
        return self.process.returncode

    def close(self):
        with contextlib.suppress(psutil.NoSuchProcess):
            for child in psutil.Process(self.process.pid).children(recursive=True):
                child.kill()
        self.process.kill()
        self.process.wait()
        for descriptor in (self.master, self.slave):
            with contextlib.suppress(OSError):
                os.close(descriptor)
