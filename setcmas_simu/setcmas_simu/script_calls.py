"""Calls of scripts: the current one, in memory that other processes can read, and failures."""

from __future__ import annotations

import ctypes
import enum
import mmap
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.fleet.topics import robot_name


class Function(enum.Enum):
    """A function of a script."""

    CONTROL = 'control'
    CONDITION = 'ctc'
    SI_TO_UNI = 'si_to_uni'
    LOADING = 'loading'
    STEP = 'step'

    def late(self, script: str, seconds: float) -> str:
        """Return that a call of a script has lasted some time, as text."""
        if self is Function.LOADING:
            return f'{script} has been loading for {seconds:g} s'
        return f'{self.value} has not returned for {seconds:g} s'


@dataclass(frozen=True)
class ScriptCall:
    """A call of a function of a script, by its file name, for a robot."""

    robot: int
    script: str
    function: Function

    def __str__(self) -> str:
        """Return the call as text, such as `control of law.py for tb3_2`."""
        return f'{self.function.value} of {self.script} for {robot_name(self.robot)}'


@dataclass(frozen=True)
class ScriptFailure:
    """A period in which all calls of a script for a robot failed for the same reason.

    Attributes:
        t: Time of the first failed call in s, as control laws see it: it stands still in a pause.
        robot: Number of the robot.
        script: Name of the file with the error: the script, or a module that it imports.
        line: Line of the error in that file, if known.
        text: The message shown to the user.
        until: End of the period in s, also when the reason changed; None for the end of the run.
    """

    t: float
    robot: int
    function: Function
    script: str
    line: int | None = None
    text: str = ''
    until: float | None = None

    @property
    def first_line(self) -> str:
        """The first line of the message, without file and line number."""
        text, place = self.text.partition('\n')[0], f'{self.script}, line {self.line}'
        for before in (f'{place}: ', f'{self.script}: '):
            text = text.removeprefix(before)
        return text.removesuffix(f' at {place}')


class CurrentCall(ctypes.Structure):
    """The script call of a process, which notes it here; in shared memory it survives the process.

    Attributes:
        calls: How many calls have begun.
        since: Start of the last call, in s on the steady clock.
        is_reported: Whether the process has told the user that this call does not return.
    """

    calls: int
    since: float
    is_reported: bool
    _fields_ = (
        ('calls', ctypes.c_long),
        ('since', ctypes.c_double),
        ('is_reported', ctypes.c_bool),
        ('_robot', ctypes.c_long),
        ('_is_running', ctypes.c_bool),
        ('_function', ctypes.c_char * 16),
        ('_script', ctypes.c_char * 256),
    )
    _path: Path | None = None
    _called: Function | None = None

    @classmethod
    def shared(cls, descriptor: int) -> CurrentCall:
        """Return the call in the memory of a file from `shared_file`."""
        return cls.from_buffer(mmap.mmap(descriptor, ctypes.sizeof(cls)))

    def begin(self, robot: int, path: Path, function: Function = Function.CONTROL) -> None:
        """Note that a function of a script is called for a robot."""
        if path is not self._path or function is not self._called:
            self._path, self._called = path, function
            self._script = os.fsencode(path.name)[:255]
            self._function = function.value.encode()
        self.since = time.monotonic()
        self.is_reported = False
        self._robot = robot
        self.calls += 1
        self._is_running = True

    def end(self) -> None:
        """Note that the call has returned."""
        self._is_running = False

    @property
    def robot(self) -> int:
        """The robot for which a script is called; 0 between calls."""
        return self._robot if self._is_running else 0

    @property
    def function(self) -> Function:
        """The function that was called last."""
        return Function(self._function.decode() or Function.CONTROL)

    @property
    def script(self) -> str:
        """File name of the script that was called last."""
        return os.fsdecode(self._script)

    def last(self) -> ScriptCall | None:
        """Return the last call that began; None before the first."""
        return ScriptCall(self._robot, self.script, self.function) if self._robot else None

    def running(self) -> ScriptCall | None:
        """Return the call that has not returned; None between calls."""
        return self.last() if self._is_running else None

    def running_s(self, now: float) -> float:
        """Return how long a call has been running at a time in s (steady); 0 between calls."""
        return now - self.since if self._is_running else 0.0


def shared_file() -> int:
    """Return a descriptor for `CurrentCall.shared`: a file in memory where the system has them."""
    if sys.platform == 'linux':
        descriptor = os.memfd_create('setcmas_current_call')
    else:
        import tempfile  # here: nodes have no use for it, and it imports half a megabyte

        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.truncate(descriptor, ctypes.sizeof(CurrentCall))
    return descriptor
