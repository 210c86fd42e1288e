"""Shared memory that shows the launcher which script call a process is in, or died in.

It survives the process, however that ends, and a script that closes all descriptors. Recording a
call takes about a microsecond.
"""

from __future__ import annotations

import mmap
import os
import struct
import sys
import tempfile
from pathlib import Path

from setcmas_simu.reports.reports import Function, ScriptCall

_SIZE = 4096
_HEAD = struct.Struct('=dIBBH')  # since (s, steady), robot, function, running, length of the name
_FUNCTIONS = tuple(Function)


def shared_file() -> int:
    """Return a descriptor for `CurrentCall`: a file in memory where the system has them."""
    if sys.platform == 'linux':
        descriptor = os.memfd_create('setcmas_current_call')
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.write(descriptor, bytes(_SIZE))
    return descriptor


class CurrentCall:
    """The script call that a process is in: the process writes it, the launcher reads it."""

    def __init__(self, descriptor: int = -1) -> None:
        """Map the file's memory; without a file, use memory of this process."""
        self._memory = mmap.mmap(descriptor, _SIZE)
        self._path: Path | None = None
        self._name = b''

    def begin(self, robot: int, path: Path, function: Function, now: float) -> None:
        """Record the start of a call at a time in s on the steady clock."""
        if path is not self._path:
            self._path = path
            self._name = os.fsencode(path.name)[: _SIZE - _HEAD.size]
            self._memory[_HEAD.size : _HEAD.size + len(self._name)] = self._name
        function_index = _FUNCTIONS.index(function)
        _HEAD.pack_into(self._memory, 0, now, robot, function_index, 1, len(self._name))

    def end(self) -> None:
        """Record the return of the call."""
        self._memory[_RUNNING] = 0

    def last(self) -> ScriptCall | None:
        """Return the last call that began; None before the first."""
        _, robot, function, _, length = _HEAD.unpack_from(self._memory)
        if not robot:
            return None
        name = os.fsdecode(self._memory[_HEAD.size : _HEAD.size + length])
        return ScriptCall(robot, name, _FUNCTIONS[function])

    def running(self) -> ScriptCall | None:
        """Return the call in progress; None between calls."""
        return self.last() if self._memory[_RUNNING] else None

    @property
    def since(self) -> float:
        """Start of the last call in s on the steady clock."""
        since: float = _HEAD.unpack_from(self._memory)[0]
        return since

    def running_s(self, now: float) -> float:
        """Return how long the current call has been running at a time in s; 0 between calls."""
        return now - self.since if self._memory[_RUNNING] else 0.0

    def close(self) -> None:
        """Release the memory."""
        self._memory.close()


_RUNNING = struct.calcsize('=dIB')  # offset of the flag
