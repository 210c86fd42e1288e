"""Offline run in a process of its own: a script that hangs or dies ends it, not the command."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from launch_scripts.processes.child_process import KILL, adopt_orphans, children, end_orphans
from launch_scripts.processes.node_commands import OFFLINE_WORKER, node_command
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.scripts.call_watch import STUCK_S
from setcmas_ctrl.scripts.script_errors import described_place, quoted_line
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.reports import Function
from setcmas_simu.robots.models import model_names
from setcmas_tools.offline.board import Board
from setcmas_tools.offline.where import WHERE, told_places
from setcmas_tools.offline.worker import BOARD, JOB, MISTAKE, MISTAKEN, RUN
from setcmas_tools.run.run import Run

_LOOK_S = 0.05
_ANSWER_S = 0.5
_PLACE_S = 2.0  # a process that waits for a core answers late


@dataclass(frozen=True)
class BrokenRun:
    """What is left of a run that a script has ended.

    Attributes:
        states: As `Board.states`, as far as they came.
        robot: Number of the robot whose script ended it; 0 if that is not known.
        reason: How, with script and line.
        function: What of the script was called.
        file: Name of the file that it was in; empty if that is not known.
        line: The line there; 0 if it is not known.
    """

    states: Floats
    robot: int
    reason: str
    function: Function = Function.CONTROL
    file: str = ''
    line: int = 0

    def __str__(self) -> str:
        """Return what ended it, with the robot's name."""
        return f'{robot_name(self.robot)}: {self.reason}' if self.robot else self.reason


class OfflineProcess:
    """The process; use as a context manager, which leaves nothing of it behind."""

    def __init__(self, job: Mapping[str, Any], scripts: LawScripts) -> None:
        """Start the process.

        Args:
            job: Arguments of `simulate`.
            scripts: The control scripts, in whose files the place is looked for.
        """
        self._scripts = scripts
        others = {*model_names(job.get('model'), job.get('nb_robots', 1)), str(job.get('ctc'))}
        self._other_scripts = [Path(name).resolve() for name in others if name.endswith('.py')]
        self._strangers = children()
        adopt_orphans()
        self._temporary = tempfile.TemporaryDirectory(prefix='setcmas_')
        self._folder = Path(self._temporary.name)
        (self._folder / JOB).write_bytes(pickle.dumps(dict(job)))
        (self._folder / WHERE).touch()
        self._board = Board(self._folder / BOARD)
        self._process = subprocess.Popen(
            node_command(OFFLINE_WORKER, [str(self._folder)]),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=os.environ | {'PYTHONUNBUFFERED': '1'},
            start_new_session=True,  # Ctrl-C is answered here
        )
        self._readers = [
            threading.Thread(target=_copy, args=pair, daemon=True)
            for pair in ((self._process.stdout, sys.stdout), (self._process.stderr, sys.stderr))
        ]
        for reader in self._readers:
            reader.start()

    def __enter__(self) -> OfflineProcess:
        """Return the process."""
        return self

    def __exit__(self, *exc_info: object) -> None:
        """End the process, and what scripts have started in it."""
        self._kill()
        self._temporary.cleanup()

    def run(
        self, call_timeout: float, warn: Callable[[str], None], on_state: Callable[[int], None]
    ) -> Run | BrokenRun:
        """Wait for the end; returns the run, or a `BrokenRun`.

        Args:
            call_timeout: Time in s after which a call that does not return ends the run.
            warn: Shows a message to the user.
            on_state: Is told now and then how many states are complete.

        Raises:
            SetcmasError: The user's mistake that the process has found.
        """
        calls, since, told = -1, time.monotonic(), False
        while self._process.poll() is None:
            on_state(self._board.done)
            now = time.monotonic()
            if self._board.calls != calls or not self._board.robot:
                calls, since, told = self._board.calls, now, False
            elif now - since > call_timeout:
                return self._broken(f'{self._late(call_timeout)} (--call-timeout)')
            elif now - since > STUCK_S and not told:
                told = True
                warn(f'{robot_name(self._board.robot)}: {self._late(STUCK_S)}{self._place()}')
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(_LOOK_S)
        status = self._process.returncode
        self._kill()
        on_state(self._board.done)
        return self._result(status)

    @property
    def elapsed(self) -> float:
        """How long the run has taken in s, without the start of the process; 0 if it broke."""
        return self._board.elapsed

    def states(self) -> Floats:
        """Return the states so far, as `Board.states`."""
        return np.array(self._board.states())

    def place(self) -> str:
        """Return where in the script the process is now, or was last; empty if that is unknown."""
        return self._place(' in ')

    def _result(self, status: int) -> Run | BrokenRun:
        with suppress(Exception):  # the script may have put anything into the run
            run = pickle.loads((self._folder / RUN).read_bytes()) if status == 0 else None
            if isinstance(run, Run):
                return run
        mistake = ''
        with suppress(OSError):
            mistake = (self._folder / MISTAKE).read_text(encoding='utf-8')
        if status == MISTAKEN and mistake:
            raise SetcmasError(mistake)
        if mistake:
            return self._broken(f'the script has broken the simulation itself: {mistake}')
        if status < 0:
            return self._broken(f'the process was killed by {signal.Signals(-status).name}')
        return self._broken(f'the process ended with exit status {status}')

    def _late(self, seconds: float) -> str:
        if self._board.function is Function.LOADING:
            script = self._scripts.script(self._board.robot)
            return f'{script.name} has been loading for {seconds:g} s'
        return f'{self._board.function.value} has not returned for {seconds:g} s'

    def _broken(self, reason: str) -> BrokenRun:
        file, line, told = self._where()
        self._kill()  # after it has told its place
        place = f' at {told}' if told else ''
        board, reason = self._board, f'{reason}{place}'
        return BrokenRun(self.states(), board.robot, reason, board.function, file, line)

    def _place(self, before: str = '; it is at ') -> str:
        """Return the place in the script with its line; empty if it is not known."""
        *_, told = self._where()
        return f'{before}{told}' if told else ''

    def _where(self) -> tuple[str, int, str]:
        """Return file, line, and both in words with the line itself; empty if not known."""
        where = self._folder / WHERE
        size = where.stat().st_size
        if size and self._process.poll() is None:
            self._process.send_signal(signal.SIGUSR1)
            deadline = time.monotonic() + _PLACE_S
            while time.monotonic() < deadline:  # it comes line by line
                if found := self._told_after(size):
                    return found
                time.sleep(0.01)
        return self._told_after(0) or ('', 0, '')

    def _told_after(self, size: int) -> tuple[str, int, str] | None:
        """Return the place that was told in whole lines behind some bytes; None if none was."""
        lines = (self._folder / WHERE).read_bytes()[size:].rpartition(b'\n')[0]
        for file, line in told_places(lines.decode(errors='replace')):
            for script in (*self._scripts.paths, *self._other_scripts):
                if file.parent == script.parent:
                    there = described_place(file, line, script)
                    return file.name, line, f'{there}{quoted_line(file, line)}'
        return None

    def _kill(self) -> None:
        """End what is left, with what the script has started."""
        if hasattr(os, 'killpg'):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, KILL)
        self._process.kill()
        self._process.wait()
        end_orphans(self._strangers)
        for reader in self._readers:
            reader.join(_ANSWER_S)


def _copy(source: IO[bytes], target: IO[str]) -> None:
    with source:
        for line in source:
            target.write(line.decode(errors='replace'))
            target.flush()
