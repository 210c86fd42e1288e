"""Call of a function that runs scripts, in a child of a host: its result, or where it stopped."""

from __future__ import annotations

import mmap
import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.scripts import robot_script
from setcmas_ctrl.scripts.script_errors import summarise
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.reports.current_call import SIZE, CurrentCall
from setcmas_tools.offline import run_progress
from setcmas_tools.offline.child_channel import Channel
from setcmas_tools.offline.forked_child import Child
from setcmas_tools.offline.host import Host

_BOARD = 'board'
_exit = os._exit
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


class Kind(Enum):
    """How a call ended: with a result, by the user's mistake, or by a script that broke it."""

    RESULT = 'result'
    MISTAKE = 'mistake'
    BROKEN = 'broken'


@dataclass(frozen=True)
class ScriptCall:
    """Work of a child: calls a function, and sends its result.

    Attributes:
        function: The function; takes the folder of the child.
    """

    function: Callable[[Path], Any]

    def begin(
        self,
        host: Host,
        files: Mapping[str, bytes] | None = None,
        limits: Mapping[str, int] | None = None,
    ) -> tuple[Child, Board]:
        """Begin it in a child of a host; return the child, and the board with its progress."""
        empty = {_BOARD: bytes(HEAD)}
        child = host.begin(pickle.dumps(self), {**(files or {}), **empty}, limits)
        return child, Board(child.folder / _BOARD)

    def __call__(self, channel: Channel, folder: Path) -> None:
        """Call the function in this process."""
        run_progress.current = now = Board(folder / _BOARD)  # type: ignore[assignment]
        robot_script.on_call = now.begin_step
        try:
            kind, result = Kind.RESULT, self.function(folder)
        except SetcmasError as error:
            kind, result = Kind.MISTAKE, str(error)
        except BaseException as error:  # a script has changed what the simulation is made of
            kind, result = Kind.BROKEN, summarise(error)
        channel.send(pickle.dumps((kind.value, result)), float('inf'))


def result_of(message: bytes) -> tuple[Kind, Any]:
    """Return the kind of an answer, and its result or message."""
    try:
        kind, result = pickle.loads(message)
        return Kind(kind), result
    except Exception as error:  # the script may have put anything into the result
        return Kind.BROKEN, summarise(error)


def only_here() -> Callable[[float], None]:
    """Return a function that ends a fork of this process, made by a script, at its next step."""
    process = os.getpid()

    def check(_: float) -> None:
        if os.getpid() != process:
            _exit(0)

    return check


def import_engine() -> None:
    """Import the modules for simulated runs."""
    import setcmas_tools.offline.engine  # noqa: F401
