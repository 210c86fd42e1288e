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

ESCAPE = re.compile('\x1b\\[[0-9;?]*[A-Za-z]')


class Terminal:
    """A terminal of one's own with a setcmas command in it."""

    def __init__(self, *arguments):
        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.slave, termios.TIOCSWINSZ, struct.pack('4H', 30, 110, 0, 0))
        self.before = termios.tcgetattr(self.slave)
        self.text = ''
        self._decoder = codecs.getincrementaldecoder('utf-8')()
        self.process = subprocess.Popen(
            [*SETCMAS, *arguments],
            stdin=self.slave,
            stdout=self.slave,
            stderr=self.slave,
            env={**os.environ, 'TERM': 'xterm-256color'},
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )
        os.set_blocking(self.master, False)

    def read(self):
        with contextlib.suppress(BlockingIOError, OSError):
            self.text += ESCAPE.sub('', self._decoder.decode(os.read(self.master, 65536)))
        return self.text

    def wait_for(self, pattern, timeout=TIMEOUT_S):
        deadline = time.monotonic() + timeout
        while not (found := re.search(pattern, self.read(), re.DOTALL)):
            assert time.monotonic() < deadline, self.text
            time.sleep(0.02)
        self.text = ''
        return found

    def press(self, key):
        os.write(self.master, key.encode())

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
