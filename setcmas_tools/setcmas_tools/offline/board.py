"""Board: states and current call of an offline run, in memory that another process reads.

It survives the process of the run, however a script ends it.
"""

from __future__ import annotations

import mmap
from pathlib import Path

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.reports.current_call import SIZE, CurrentCall

HEAD = SIZE + 32
"""Size of the records before the states, in bytes."""
_DONE, _STATES, _ROWS, _ROBOTS = range(4)


class Board(CurrentCall):
    """Records of a run: in memory of its own, or in a file that another process reads."""

    def __init__(self, path: Path | None = None) -> None:
        """Open a board; a file must have HEAD bytes at least."""
        self._file = path
        memory = _mapped(path, HEAD) if path else bytearray(HEAD)
        super().__init__(memory)
        self._run = memoryview(memory)[SIZE:HEAD].cast('q')

    @property
    def done(self) -> int:
        """Number of complete states."""
        return self._run[_DONE]

    @done.setter
    def done(self, states: int) -> None:
        self._run[_DONE] = states

    def new_states(self, nb_states: int, nb_robots: int, nb_rows: int = 6) -> Floats:
        """Return an array for the states of a run, shape (nb_states, nb_rows, nb_robots)."""
        shape = nb_states, nb_rows, nb_robots
        self._run[_STATES], self._run[_ROWS], self._run[_ROBOTS] = shape
        return self._array(shape)

    def states(self) -> Floats:
        """Return the complete states."""
        shape = (self._run[_STATES], self._run[_ROWS], self._run[_ROBOTS])
        return self._array(shape)[: self.done]

    def begin_step(self, robot: int, _: Path) -> None:
        """Record that a robot's script is called."""
        self.begin(robot)

    def _array(self, shape: tuple[int, int, int]) -> Floats:
        if self._file is None:
            return np.empty(shape)
        size = 8 * shape[0] * shape[1] * shape[2]
        return np.frombuffer(_mapped(self._file, HEAD + size), offset=HEAD).reshape(shape)


def _mapped(path: Path, size: int) -> mmap.mmap:
    with path.open('r+b') as file:
        if file.seek(0, 2) < size:
            file.truncate(size)
        return mmap.mmap(file.fileno(), 0)
