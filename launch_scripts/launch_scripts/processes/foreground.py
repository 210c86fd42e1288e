"""A node process that runs in the foreground, until it ends or Ctrl-C."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from launch_scripts.processes.child_process import Child, ChildDiedError
from launch_scripts.processes.environment import local_environment
from launch_scripts.processes.node_commands import EMULATED_LAB, node_command, stop_robots_of
from launch_scripts.processes.supervisor import StoppedError, Supervisor
from setcmas_simu.reports.reports import Ready


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
    own = environment or local_environment()
    with Supervisor(own, prefix=bool(companions)) as supervisor:
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
