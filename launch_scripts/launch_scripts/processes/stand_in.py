"""Zero velocity in place of a controller process that hangs or has died."""

from __future__ import annotations

from launch_scripts.processes.node_commands import STAND_IN, node_command
from launch_scripts.processes.supervision.child_process import Child
from launch_scripts.processes.supervision.supervisor import Supervisor
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.reports.reports import Started


def stop_robots_of(supervisor: Supervisor, ctrl: Child) -> None:
    """Command zero to the robots of a controller process, if it has commanded them.

    In experiments the bridge does it, and sooner.
    """
    started = ctrl.heard(Started)
    if started:
        robots = format_robots(list(started.robots))
        supervisor.run_aside(node_command(STAND_IN, ['--robots', robots]))
