"""A node process that runs in the foreground, until Ctrl-C or its end."""

from __future__ import annotations

from collections.abc import Sequence

from launch_scripts.processes.child_process import ChildDiedError
from launch_scripts.processes.environment import local_environment
from launch_scripts.processes.supervisor import StoppedError, Supervisor


def run_in_foreground(
    name: str,
    command: Sequence[str],
    companions: Sequence[tuple[str, Sequence[str]]] = (),
) -> int:
    """Run a process, and its companions if any, until Ctrl-C; return the exit status.

    Topics stay on this machine, and the process must not end by itself.
    """
    with Supervisor(local_environment(), prefix=bool(companions)) as supervisor:
        child = supervisor.start(name, command)
        for companion, its_command in companions:
            supervisor.start(companion, its_command, needed=False)
        try:
            supervisor.run()
        except StoppedError:
            supervisor.stop(child)
            return child.exit_status
        except ChildDiedError as death:
            return supervisor.report_death(death)
    return 0
