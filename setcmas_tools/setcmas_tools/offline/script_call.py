"""Call of a function that runs scripts, in a child of a host: its result, or where it stopped."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from setcmas_ctrl.scripts import robot_script
from setcmas_ctrl.scripts.script_errors import summarise
from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline import board, run_progress
from setcmas_tools.offline.child_channel import Channel
from setcmas_tools.offline.forked_child import Child
from setcmas_tools.offline.host import Host

_BOARD = 'board'
_exit = os._exit


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
    ) -> tuple[Child, board.Board]:
        """Begin it in a child of a host; return the child, and the board with its progress."""
        empty = {_BOARD: bytes(board.HEAD)}
        child = host.begin(pickle.dumps(self), {**(files or {}), **empty}, limits)
        return child, board.Board(child.folder / _BOARD)

    def __call__(self, channel: Channel, folder: Path) -> None:
        """Call the function in this process."""
        run_progress.current = now = board.Board(folder / _BOARD)  # type: ignore[assignment]
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
