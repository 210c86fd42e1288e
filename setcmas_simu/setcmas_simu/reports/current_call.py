"""Shared memory that shows other processes which script call a process is in, or died in.

It survives the process, however that ends, and a script that closes all descriptors. Recording a
call takes a few tenths of a microsecond.
"""

from __future__ import annotations

import mmap
import os
import sys
import tempfile
from pathlib import Path

from setcmas_simu.reports.script_calls import Function, ScriptCall

SIZE = 512
"""Bytes that a `CurrentCall` takes."""

_CALLS, _ROBOT, _FUNCTION, _RUNNING, _LENGTH, _SINCE = range(6)
_NAME = 64  # where the name of the script begins
_FUNCTIONS = tuple(Function)


def shared_file() -> int:
    """Return a descriptor for `CurrentCall.shared`: a file in memory where the system has them."""
    if sys.platform == 'linux':
        descriptor = os.memfd_create('setcmas_current_call')
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.write(descriptor, bytes(SIZE))
    return descriptor


class CurrentCall:
    """The script call of a process: the process itself writes it, others read it."""

    def __init__(self, memory: bytearray | memoryview | mmap.mmap | None = None) -> None:
        """Use the first bytes of some memory; by default of new memory of this process alone."""
        view = memoryview(bytearray(SIZE) if memory is None else memory)
        self._notes = view[:_NAME].cast('q')
        self._times = view[:_NAME].cast('d')
        self._text = view[_NAME:SIZE]
        self._path: Path | None = None

    @classmethod
    def shared(cls, descriptor: int) -> CurrentCall:
        """Return the call in the memory of a file."""
        return cls(mmap.mmap(descriptor, SIZE))

    def enter(self, function: Function, path: Path | None = None) -> None:
        """Record the function of the script that the next calls run."""
        self._notes[_FUNCTION] = _FUNCTIONS.index(function)
        if path is not None and path is not self._path:
            self._path = path
            name = os.fsencode(path.name)[: len(self._text)]
            self._text[: len(name)] = name
            self._notes[_LENGTH] = len(name)

    def begin(self, robot: int, now: float = 0.0) -> None:
        """Record that a call begins for a robot, at a time in s on the steady clock."""
        self._times[_SINCE] = now
        self._notes[_ROBOT] = robot
        self._notes[_CALLS] += 1
        self._notes[_RUNNING] = 1

    def end(self) -> None:
        """Record that the call has returned."""
        self._notes[_RUNNING] = 0

    @property
    def calls(self) -> int:
        """How many calls have begun."""
        return self._notes[_CALLS]

    @property
    def robot(self) -> int:
        """The robot for which a script is called; 0 between calls."""
        return self._notes[_ROBOT] if self._notes[_RUNNING] else 0

    @property
    def function(self) -> Function:
        """The function that was called last."""
        return _FUNCTIONS[self._notes[_FUNCTION]]

    @property
    def since(self) -> float:
        """Start of the last call, in s on the steady clock."""
        return self._times[_SINCE]

    def last(self) -> ScriptCall | None:
        """Return the last call that began; None before the first."""
        robot = self._notes[_ROBOT]
        if not robot:
            return None
        name = os.fsdecode(bytes(self._text[: self._notes[_LENGTH]]))
        return ScriptCall(robot, name, self.function)

    def running(self) -> ScriptCall | None:
        """Return the call that has not returned; None between calls."""
        return self.last() if self._notes[_RUNNING] else None

    def running_s(self, now: float) -> float:
        """Return how long a call has been running at a time in s; 0 between calls."""
        return now - self.since if self._notes[_RUNNING] else 0.0
