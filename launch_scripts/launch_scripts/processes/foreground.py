"""A node process that runs in the foreground, until it ends or Ctrl-C."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from functools import partial
from typing import NoReturn

from launch_scripts.processes.child_process import Child, ChildDiedError
from launch_scripts.processes.environment import local_environment
from launch_scripts.processes.node_commands import EMULATED_LAB, node_command, stop_robots_of
from launch_scripts.processes.supervisor import STOP_SIGNALS, StoppedError, Supervisor
from launch_scripts.terminal.terminal import kept_terminal
from setcmas_simu.reports.reports import Ready

_MAY_END = '--may-end'


def run_in_foreground(
    name: str,
    command: Sequence[str],
    companions: Sequence[tuple[str, Sequence[str]]] = (),
    environment: dict[str, str] | None = None,
    may_end: bool = False,
) -> int:
    """Run a process, and its companions if any, until Ctrl-C; return the exit status.

    By default, topics stay on this machine, and the process must not end by itself.
    """
    environment = environment or local_environment()
    if not companions:
        _become_supervisor([*[_MAY_END] * may_end, name, *command], environment)
    return _supervise(name, command, companions, environment, may_end)


def _become_supervisor(arguments: Sequence[str], environment: dict[str, str]) -> NoReturn:
    """Replace this process: what checked the command would keep 18 MB until the end."""
    sys.stdout.flush()
    sys.stderr.flush()
    signal.pthread_sigmask(signal.SIG_BLOCK, STOP_SIGNALS)  # they wait for the supervisor
    supervisor = node_command('launch_scripts.processes.foreground', arguments)
    os.execve(supervisor[0], supervisor, environment)


def _supervise(
    name: str,
    command: Sequence[str],
    companions: Sequence[tuple[str, Sequence[str]]],
    environment: dict[str, str],
    may_end: bool,
) -> int:
    with Supervisor(environment, prefix=bool(companions)) as supervisor:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
        child = supervisor.start(name, command)
        child.on_hang = partial(stop_robots_of, supervisor, child)
        for companion, its_command in companions:
            supervisor.start(companion, its_command, needed=False)
        try:
            supervisor.run()
        except StoppedError:
            supervisor.stop(child)
            if child.killed:
                stop_robots_of(supervisor, child)
            return child.exit_status
        except ChildDiedError as death:
            if may_end and child.process.returncode == 0:
                return 0
            stop_robots_of(supervisor, child)
            return supervisor.report_death(death)
    return 0


def start_emulated_lab(supervisor: Supervisor, arguments: Sequence[str]) -> Child:
    """Start an emulated lab; return it once it has made sure that it is the only one.

    Raises:
        ChildDiedError: The lab ended.
        StoppedError: The user stopped the command.
    """
    lab = supervisor.start('lab', node_command(EMULATED_LAB, arguments))
    supervisor.run(until=lambda: lab.reported(Ready) is not None)
    return lab


def main() -> int:
    """Supervise the process that the arguments name; return its exit status."""
    arguments = sys.argv[1:]
    may_end = arguments[0] == _MAY_END
    name, *command = arguments[may_end:]
    with kept_terminal():
        return _supervise(name, command, (), dict(os.environ), may_end)


if __name__ == '__main__':
    sys.exit(main())
