"""Offline run in a process of its own: a script that hangs or dies ends it, not the command."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO

import numpy as np

from setcmas_ctrl.scripts.call_watch import STUCK_S
from setcmas_ctrl.scripts.output import named_output
from setcmas_ctrl.scripts.script_errors import described_place, quoted_line
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.offline.board import Board
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.forked_child import Child, EndedError, script_of
from setcmas_tools.offline.host import Host
from setcmas_tools.offline.script_call import Kind, ScriptCall, only_here, result_of
from setcmas_tools.run.run import Run
from setcmas_tools.scenario.scenario import Scenario

_LOOK_S = 0.05
_ANSWER_S = 0.5
_output = ExitStack()
"""Names the output of scripts until the process ends, for their threads print on."""


@dataclass(frozen=True)
class BrokenRun:
    """A run that a script has ended.

    Attributes:
        states: Its states so far, as from `Board.states`.
        robot: Number of the robot whose script ended it; 0 if unknown.
        reason: The cause, with script and line.
        function: The function that was called.
        file: Name of the file where it was; empty if unknown.
        line: The line there; 0 if unknown.
    """

    states: Floats
    robot: int
    reason: str
    function: Function = Function.CONTROL
    file: str = ''
    line: int = 0

    def __str__(self) -> str:
        return f'{robot_name(self.robot)}: {self.reason}' if self.robot else self.reason


class OfflineRun:
    """A run in a process of its own; use as a context manager, which ends the process.

    It begins with `result`, so that Ctrl-C meets no run that has begun elsewhere.

    Attributes:
        elapsed: Duration of the simulation in s, without the start of the process; 0 if it broke.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Prepare it.

        Args:
            scenario: The scenario, as from `Scenario.found`.
        """
        self._scenario = scenario
        self._scripts = scenario.law.scripts()
        names = {*scenario.named('model'), *scenario.named('ctc')}
        others = [Path(name).resolve() for name in names if name.endswith('.py')]
        self._paths = [*self._scripts.paths, *others]
        self._folders = {path.parent for path in self._paths}
        self.elapsed = 0.0
        self._host = Host(
            'setcmas_tools.offline.script_call:import_engine',
            environment={'PYTHONUNBUFFERED': '1'},
            output=subprocess.PIPE,
        )
        self._child: Child | None = None
        self._board = Board()
        self._readers: list[threading.Thread] = []

    def __enter__(self) -> OfflineRun:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._host.close()
        for reader in self._readers:
            reader.join(_ANSWER_S)

    def result(
        self, call_timeout: float, warn: Callable[[str], None], on_state: Callable[[int], None]
    ) -> Run | BrokenRun:
        """Wait for the end; return the run, or a `BrokenRun`.

        Args:
            call_timeout: Time in s after which a call that does not return ends the run.
            warn: Shows a message to the user.
            on_state: Called now and then with the number of complete states.

        Raises:
            SetcmasError: The scenario or a script is invalid.
        """
        child = self._begin()
        try:
            message = self._message(child, call_timeout, warn, on_state)
        except EndedError as error:
            return self._broken(str(error), error.places)
        on_state(self._board.done)
        kind, result = result_of(message)
        if kind is Kind.RESULT:
            self.__exit__()  # all that it has printed is shown
            run: Run
            run, self.elapsed = result
            return run
        if kind is Kind.MISTAKE:
            raise SetcmasError(result)
        return self._broken(f'the script has broken the simulation itself: {result}', [])

    def states(self) -> Floats:
        """Return the states so far, as `Board.states`."""
        return np.array(self._board.states())

    def place(self) -> str:
        """Return the current or last place in the script as text; empty if unknown."""
        return self._described(self._child.places(self._folders), ' in ') if self._child else ''

    def _begin(self) -> Child:
        call = ScriptCall(partial(_simulated, self._scenario))
        self._child, self._board = call.begin(self._host)
        process = self._host.process
        assert process
        assert process.stdout
        assert process.stderr
        for source, target in ((process.stdout, sys.stdout), (process.stderr, sys.stderr)):
            reader = threading.Thread(target=_copy, args=(source, target), daemon=True)
            reader.start()
            self._readers.append(reader)
        return self._child

    def _message(
        self,
        child: Child,
        call_timeout: float,
        warn: Callable[[str], None],
        on_state: Callable[[int], None],
    ) -> bytes:
        calls, since, warned = -1, time.monotonic(), False
        while (message := child.poll(_LOOK_S)) is None:
            on_state(self._board.done)
            now = time.monotonic()
            if self._board.calls != calls or not self._board.robot:
                calls, since, warned = self._board.calls, now, False
            elif now - since > call_timeout:
                places = child.places(self._folders)
                late = f'{self._late(call_timeout)} (--call-timeout)'
                raise EndedError(late, child.end(), places)
            elif now - since > STUCK_S and not warned:
                warned = True
                place = self._described(child.places(self._folders), '; it is at ')
                warn(f'{robot_name(self._board.robot)}: {self._late(STUCK_S)}{place}')
        return message

    def _late(self, seconds: float) -> str:
        if self._board.function is Function.LOADING:
            script = self._scripts.script(self._board.robot)
            return f'{script.name} has been loading for {seconds:g} s'
        return f'{self._board.function.value} has not returned for {seconds:g} s'

    def _broken(self, reason: str, places: list[tuple[Path, int]]) -> BrokenRun:
        states = self.states()
        self.__exit__()
        file, line = script_of(places, self._folders) or (Path(), 0)
        board, reason = self._board, f'{reason}{self._described(places, " at ")}'
        return BrokenRun(states, board.robot, reason, board.function, file.name, line)

    def _described(self, places: list[tuple[Path, int]], before: str) -> str:
        """Return the place in the script with its line; empty if unknown."""
        if found := script_of(places, self._folders):
            file, line = found
            script = next(path for path in self._paths if path.parent == file.parent)
            there = described_place(file, line, file if file in self._paths else script)
            return f'{before}{there}{quoted_line(file, line)}'
        return ''


def _simulated(scenario: Scenario, _: Path) -> tuple[Run, float]:
    """Simulate in this process; return the run, and the time that it took in s."""
    _output.enter_context(named_output())
    begin = time.perf_counter()
    run = simulate(scenario, warn=_warn, progress=only_here())
    return run, time.perf_counter() - begin


def _warn(message: str) -> None:
    print(message, file=sys.stderr, flush=True)


def _copy(source: IO[bytes], target: IO[str]) -> None:
    with source:
        for line in source:
            target.write(line.decode(errors='replace'))
            target.flush()
