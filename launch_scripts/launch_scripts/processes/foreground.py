"""Foreground run of one process of nodes, until it ends or the user ends it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from launch_scripts.processes.environment import local_environment
from launch_scripts.processes.stand_in import stop_robots_of
from launch_scripts.processes.supervision.child_process import ChildDiedError
from launch_scripts.processes.supervision.supervisor import StoppedError, Supervisor


def run_in_foreground(
    name: str,
    command: Sequence[str],
    companions: Sequence[tuple[str, Sequence[str]]] = (),
) -> int:
    """Run a process until Ctrl-C; returns the exit status, 0 if it ended well.

    Args:
        name: What the user calls the process.
        command: Program and arguments.
        companions: Names and commands of processes that end with it, but that it can do without.
    """
    with Supervisor(local_environment(), prefix=bool(companions)) as supervisor:
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
            stop_robots_of(supervisor, child)
            if str(death):
                supervisor.warn(f'setcmas: {death}')
            return death.exit_status
    return 0
