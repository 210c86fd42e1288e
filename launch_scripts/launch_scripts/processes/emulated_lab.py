"""Start of an emulated lab, before whatever works with it."""

from __future__ import annotations

from collections.abc import Sequence

from launch_scripts.processes.node_commands import EMULATED_LAB, node_command
from launch_scripts.processes.supervision.child_process import Child
from launch_scripts.processes.supervision.supervisor import Supervisor
from setcmas_simu.reports.reports import Ready


def start_emulated_lab(supervisor: Supervisor, arguments: Sequence[str]) -> Child:
    """Start an emulated lab, and return it once it works.

    A second lab of the same robots refuses to start; nothing is to command them before.

    Raises:
        ChildDiedError: It has ended.
        StoppedError: The user asked the command to end.
    """
    lab = supervisor.start('lab', node_command(EMULATED_LAB, arguments))
    supervisor.run(until=lambda: lab.heard(Ready) is not None)
    return lab
