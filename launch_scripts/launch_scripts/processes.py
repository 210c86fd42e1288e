"""Processes of a command: their command lines, and what a running one has reported."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeVar, cast

from setcmas_simu.reports import VARIABLE as LAUNCHER_VARIABLE
from setcmas_simu.reports import (
    Ended,
    Failed,
    LineDecoder,
    Mistake,
    ProcessMessage,
    encode,
    end_with_parent,
)
from setcmas_simu.script_calls import CurrentCall, Function, ScriptCall, ScriptFailure, shared_file

SIMULATOR = 'setcmas_simu.simulator'
CONTROLLER = 'setcmas_ctrl.controllers.controller_processes'
CAMERA = 'setcmas_expe.mocap.camera_node'
EMULATED_LAB = 'setcmas_expe.emulation.emulated_lab'
BRIDGES = 'setcmas_expe.bridges'
PAUSE = 'setcmas_expe.pause.pause_node'
JOYSTICK_READER = 'setcmas_expe.pause.joystick'
RECORDER = 'setcmas_tools.bags.recorder'
PLAYER = 'setcmas_tools.bags.player'
BROWSER_VIEW = 'setcmas_tools.page.live_page'

PAGE = 'view'
"""Name of the process that serves the page."""

_RUN_MODULE = (
    'import runpy, sys; del sys.path[0]; '
    "runpy.run_module(sys.argv.pop(1), run_name='__main__', alter_sys=True)"
)


def add_ros_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--ros-args`, the last option: all arguments after it go to the node process."""
    parser.add_argument(
        '--ros-args',
        nargs=argparse.REMAINDER,
        default=[],
        metavar='...',
        help='arguments for ROS, such as -r __ns:=/a, -p vnom:=0.3 or --params-file gains.yaml',
    )


def namespace_rule(command: Sequence[str]) -> list[str]:
    """Return ROS arguments that move another process to the namespace in a command, if any."""
    rules = [word for word in command if word.startswith('__ns:=')]
    return ['--ros-args', '-r', rules[-1]] if rules else []


def node_command(module: str, arguments: Sequence[str] = ()) -> list[str]:
    """Return the command line that runs a module of nodes."""
    # Without the current folder in the search path: a student's random.py would hide Python's.
    # Python 3.10 has no option for that.
    run_module = ['-P', '-m'] if sys.version_info >= (3, 11) else ['-c', _RUN_MODULE]
    return [sys.executable, *run_module, module, *arguments]


HANGS_S = 3.0
"""Time in s after which a script call hangs; the process itself reports it sooner, if it can."""

AnyReport = TypeVar('AnyReport', bound=ProcessMessage)


class ChildDiedError(Exception):
    """A process ended unexpectedly; `exit_status` is for the command."""

    def __init__(self, message: str, exit_status: int = 1) -> None:
        super().__init__(message)
        self.exit_status = exit_status


class Child:
    """A running process in its own process group.

    Attributes:
        shown: Whether its output is shown.
        needed: Whether the other processes need it.
        reports: Pipe of its reports.
        call: The script call that it is in.
        failures: Periods of failed calls, as it reports at its end.
        killed: Whether it had to be killed.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: dict[str, str],
        needed: bool,
        listens: bool,
        mistake: str,
        kinds: Any,
        on_report: Callable[[ProcessMessage], object],
    ) -> None:
        """Start the process; its error messages begin with `mistake`.

        `on_report` is called with each of its reports, which have one of the types `kinds`.
        """
        self.name = name
        self.needed = needed
        self.shown = True
        self.killed = False
        self.failures: tuple[ScriptFailure, ...] = ()
        self._on_report = on_report
        self._decoder: LineDecoder[ProcessMessage] = LineDecoder(kinds)
        self._reported: dict[type[ProcessMessage], ProcessMessage] = {}
        self._failed: dict[ScriptCall, None] = {}
        reports, pipe = os.pipe()
        self.reports = os.fdopen(reports, 'rb', buffering=0)
        memory = shared_file()
        self.call = CurrentCall.shared(memory)
        self.process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE if listens else subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=environment | {LAUNCHER_VARIABLE: f'{pipe} {memory} {mistake}'},
            pass_fds=(pipe, memory),
            preexec_fn=_prepare,
        )
        os.close(pipe)
        os.close(memory)

    def running(self) -> bool:
        """Return whether the process is running."""
        return self.process.poll() is None

    def send(self, message: ProcessMessage) -> None:
        """Send a message to the standard input of the process, without waiting."""
        assert self.process.stdin is not None
        os.set_blocking(self.process.stdin.fileno(), False)
        with suppress(BlockingIOError, BrokenPipeError):  # it hangs or has ended
            os.write(self.process.stdin.fileno(), encode(message))

    def signal_group(self, signum: int) -> None:
        """Send a signal to the process and its children."""
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signum)

    def take_reports(self, data: bytes) -> None:
        """Take what has come through the pipe of reports."""
        for report in self._decoder.feed(data):
            self._reported[type(report)] = report
            if isinstance(report, Failed):
                self._failed[report.call] = None
            elif isinstance(report, Ended):
                self._failed |= dict.fromkeys(report.failed)
                self.failures = report.failures
            self._on_report(report)

    def reported(self, kind: type[AnyReport]) -> AnyReport | None:
        """Return the newest report of a kind; None if there was none."""
        return cast('AnyReport | None', self._reported.get(kind))

    @property
    def running_s(self) -> float:
        """How long a script call has been running, in s; 0 between calls."""
        return self.call.running_s(time.monotonic())

    def silent_call(self) -> ScriptCall | None:
        """Return a script call that hangs without a word of the process about it; each once."""
        if self.call.is_reported or self.running_s <= HANGS_S:
            return None
        self.call.is_reported = True
        return self.running_call()

    def running_call(self) -> ScriptCall | None:
        """Return the running script call, and count it as failed; None between calls."""
        call = self.call.running()
        if call and call.function is not Function.LOADING:
            self._failed[call] = None
        return call

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Script calls that failed, hung, or were running when the process was killed or died."""
        return tuple(self._failed)

    @property
    def missing(self) -> str:
        """Why control laws are not called yet."""
        call = self.call.running()
        return f'{call} has not returned' if call else 'the controllers have not called their laws'

    @property
    def exit_status(self) -> int:
        """Exit status of a process that was asked to stop: 0 only if nothing went wrong."""
        status = self.process.returncode
        if self.killed or (status <= 0 and self.failed):
            return 1
        if status == -signal.SIGTERM:
            return 0  # stopped before it could handle signals
        return status if status >= 0 else 128 - status  # as shells report it

    def unexpected_end(self) -> ChildDiedError:
        """Return why the process ended, as an exception."""
        status = self.process.returncode
        if status == 2 and self.reported(Mistake):
            return ChildDiedError('', 2)
        place = self._place()
        if status < 0:
            reason = f'was killed by {signal.Signals(-status).name}'
            reason += ' (out of memory?)' if -status == signal.SIGKILL else ''
            status = 128 - status  # as shells report it
        else:
            reason = f'ended unexpectedly with exit status {status}'
        message = f'{self.name} (process {self.process.pid}) {reason}{place}'
        return ChildDiedError(message, 1 if self.running_call() else status or 1)

    def _place(self) -> str:
        """Return in or after which script call the process is; '' if there was none."""
        if call := self.running_call():
            return f' in {call}'
        return f' after {call}' if (call := self.call.last()) else ''


def _prepare() -> None:
    """Give a child that begins a process group of its own, and let it end with its parent."""
    os.setpgid(0, 0)
    end_with_parent()
