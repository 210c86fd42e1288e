"""Supervisor: runs the processes of a command, shows their output, and cleans up after them."""

from __future__ import annotations

import argparse
import os
import selectors
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from types import FrameType
from typing import IO, Any, TypeVar, cast

from launch_scripts.environment import local_environment
from launch_scripts.processes import HANGS_S, Child, ChildDiedError, node_command
from launch_scripts.terminal import LineBuffer, OutputQueue, QueuedStream, Stream, write_line
from setcmas_simu.reports import WRITES_S, ProcessMessage, Recording, Report

# Ctrl-Z too: a suspended launcher would leave its robots unsupervised.
_STOPS = ('SIGINT', 'SIGTERM', 'SIGHUP', 'SIGTSTP')
STOP_SIGNALS = tuple(signal.Signals[name] for name in _STOPS if hasattr(signal, name))
_ENDS_S = 5.0
_TICK_S = 0.05  # longest delay before a key press is noticed
_LATE_S = 1.0  # a longer script call keeps its process from ending
_LATE_ENDS_S = 1.5

AnySupervisor = TypeVar('AnySupervisor', bound='Supervisor')


class StoppedError(Exception):
    """The user stopped the command (Ctrl-C, SIGTERM, closed terminal)."""


class Supervisor:
    """Runs processes, shows their output, and cleans up after them.

    Use as a context manager: on exit it stops all processes.
    """

    def __init__(self, environment: dict[str, str], prefix: bool = False) -> None:
        """Prepare; with `prefix`, lines of output start with the name of their process."""
        self.children: list[Child] = []
        self._output = OutputQueue()
        self.stdout = QueuedStream(self._output, sys.stdout)
        self.stderr = QueuedStream(self._output, sys.stderr)
        self._environment = environment
        self._prefix = prefix
        self._selector = selectors.DefaultSelector()
        self._stop_signals = 0
        self._previous_handlers: dict[signal.Signals, Any] = {}

    def __enter__(self: AnySupervisor) -> AnySupervisor:
        self._previous_handlers = _handled(dict.fromkeys(STOP_SIGNALS, self._on_signal))
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.stop(*reversed(self.children))
        for key in list(self._selector.get_map().values()):
            cast(IO[bytes], key.fileobj).close()
        self._selector.close()
        self._output.close()
        _handled(self._previous_handlers)

    def start(
        self,
        name: str,
        command: Sequence[str],
        needed: bool = True,
        listens: bool = False,
        reports: Any = Report,
        on_report: Callable[[ProcessMessage], object] = bool,
    ) -> Child:
        """Start a process and show its output.

        Args:
            name: Name of the process in messages.
            command: Program and arguments.
            needed: Whether `run` ends when it ends.
            listens: Whether it reads what `Child.send` sends.
            reports: The kinds of its reports.
            on_report: Called with each of them.
        """
        mistake = 'error' if self._prefix else f'setcmas {name}'
        environment = self._environment
        child = Child(name, command, environment, needed, listens, mistake, reports, on_report)
        self.children.append(child)
        self._watch(child.process.stdout, self._printer(child, self.stdout))
        self._watch(child.process.stderr, self._printer(child, self.stderr))
        self._watch(child.reports, child.take_reports)
        return child

    def run(
        self, until: Callable[[], bool] = lambda: False, on_tick: Callable[[], None] = lambda: None
    ) -> None:
        """Show output until a condition holds.

        Raises:
            ChildDiedError: A process ended unexpectedly.
            StoppedError: The user stopped the command.
        """
        while not until():
            self._show_output(_TICK_S)
            on_tick()
            if self._stop_signals or self._output.broken:
                raise StoppedError
            for child in list(self.children):
                if not child.running():
                    self._show_output(0)
                    if child.needed:
                        raise child.unexpected_end()
                    self.warn(f'{child.name} has ended; everything else continues')
                    self.stop(child)
                elif call := child.silent_call():
                    self.warn(
                        f'{child.name} does not answer: {call} has not returned for {HANGS_S:g} s '
                        '(a loop in C, or a suspended process); its robots get no commands until '
                        'it returns; Ctrl-C stops'
                    )

    def wait(self, seconds: float) -> None:
        """Show output for some seconds, whatever happens."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._show_output(0.02)

    def write(self, line: str, stream: Stream) -> None:
        """Write a line of output; subclasses keep it apart from what else is in the terminal."""
        write_line(line, stream)

    def warn(self, message: str) -> None:
        """Show a message of the command itself."""
        self.write(message, self.stderr)

    def report_death(self, death: ChildDiedError, verb: str = '') -> int:
        """Show why a process died, unless it has said so; return the command's exit status."""
        if reason := str(death):
            self.warn(f'{f"setcmas {verb}".rstrip()}: {reason}')
        return death.exit_status

    def stop(self, *children: Child) -> None:
        """Stop processes one after the other: by SIGTERM, then by SIGKILL."""
        for child in [child for child in children if child in self.children]:
            if child.running():  # not SIGINT: a Python that starts answers with a traceback
                child.signal_group(signal.SIGTERM)
                self._await_end(child, WRITES_S if child.reported(Recording) else _ENDS_S)
            call = child.running_call()  # which an end has interrupted, so it has failed
            if child.running():
                child.killed = True
                during = f' in {call}' if call else ''
                self.warn(f'{child.name} did not stop when asked, so it was killed{during}')
            child.signal_group(signal.SIGKILL)  # also what the process has started
            child.process.wait()
            if child.process.stdin:
                child.process.stdin.close()
            self._show_output(0)
            self.children.remove(child)

    def _await_end(self, child: Child, seconds: float) -> None:
        """Wait until a process ends; less if it hangs or the user presses Ctrl-C twice."""
        begin, signals = time.monotonic(), self._stop_signals
        while child.running() and self._stop_signals < signals + 2:
            self._show_output(0.02)
            is_late = child.running_s > _LATE_S
            if time.monotonic() - begin > (_LATE_ENDS_S if is_late else seconds):
                break

    def _watch(self, pipe: IO[bytes] | None, take: Callable[[bytes], None]) -> None:
        assert pipe is not None
        os.set_blocking(pipe.fileno(), False)
        self._selector.register(pipe, selectors.EVENT_READ, take)

    def _printer(self, child: Child, stream: Stream) -> Callable[[bytes], None]:
        lines = LineBuffer(f'[{child.name}] ' if self._prefix else '')

        def show(data: bytes) -> None:
            for line in lines.feed(data):
                if child.shown:
                    self.write(line, stream)

        return show

    def _show_output(self, timeout_s: float) -> None:
        for key, _ in self._selector.select(timeout_s):
            try:
                data = os.read(key.fd, 65536)
            except BlockingIOError:
                continue
            key.data(data)
            if not data:
                self._selector.unregister(key.fileobj)
                cast(IO[bytes], key.fileobj).close()

    def _on_signal(self, _signum: int, _frame: FrameType | None) -> None:
        self._stop_signals += 1


def _handled(handlers: Mapping[signal.Signals, Any]) -> dict[signal.Signals, Any]:
    """Set signal handlers; return the previous ones."""
    return {signum: signal.signal(signum, handler) for signum, handler in handlers.items()}


def run_node(
    args: argparse.Namespace,
    module: str,
    arguments: Sequence[str],
    companions: Sequence[tuple[str, Sequence[str]]] = (),
    environment: dict[str, str] | None = None,
    may_end: bool = False,
) -> int:
    """Run the node process of a verb until Ctrl-C; return the exit status.

    Args:
        args: The arguments of the verb, with --ros-args for the node.
        module: The module to run.
        arguments: Its arguments.
        companions: Names and commands of processes that run alongside; it does not need them.
        environment: Its environment; by default one whose topics stay on this machine.
        may_end: Whether it may end by itself.
    """
    ros = ['--ros-args', *args.ros_args] if args.ros_args else []
    with Supervisor(environment or local_environment(), prefix=bool(companions)) as supervisor:
        child = supervisor.start(args.verb, node_command(module, [*arguments, *ros]))
        for name, command in companions:
            supervisor.start(name, command, needed=False)
        try:
            supervisor.run()
        except StoppedError:
            supervisor.stop(child)
        except ChildDiedError as death:
            if not may_end or child.process.returncode < 0:
                return supervisor.report_death(death)
        return child.exit_status
