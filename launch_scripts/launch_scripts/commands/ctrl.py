"""Run a control law on every robot of a running fleet until Ctrl-C.

Examples:
  setcmas ctrl --algo consensus
  setcmas ctrl --algo my_law.py --vnom 0.2       a script of your own
  setcmas ctrl --algo my_law --watch             loads it again whenever you save it
  setcmas ctrl --algo consensus --set K=1.2      another gain for this time
  setcmas ctrl --algo nav_wp --nb-robots 8 --robots 5-8
  setcmas ctrl --algo consensus --event-triggered --graph ring
"""

from __future__ import annotations

import argparse

from launch_scripts.options.rviz import shown_robots
from launch_scripts.options.view_options import NONE, add_view_arguments, view_beside
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.node_arguments import node_arguments
from launch_scripts.processes.node_commands import CONTROLLER, CONTROLLER_OPTIONS, node_command
from setcmas_ctrl.communication.options import add_communication_arguments, check_communication
from setcmas_ctrl.control.options import add_fleet_arguments, add_law_arguments, add_watch_argument
from setcmas_ctrl.scripts.loader import compile_script, find_script
from setcmas_ctrl.scripts.settings import parse_settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_watch_argument(add_law_arguments(parser))
    add_fleet_arguments(parser)
    add_communication_arguments(parser)
    add_view_arguments(parser, default=NONE)  # the simulator shows the robots already


def main(args: argparse.Namespace) -> int:
    """Control until Ctrl-C; returns the exit status."""
    script = find_script(args.algo, args.exercise)
    # Mistakes are told before anything starts.
    compile_script(script, settings=parse_settings(args.set))
    robots = shown_robots(args)
    check_communication(args, args.nb_robots)
    require_ros()
    with view_beside(args, robots) as companions:
        command = node_command(CONTROLLER, node_arguments(args, CONTROLLER_OPTIONS))
        return run_in_foreground('ctrl', command, companions)
