"""Simulate a fleet of robots on ROS 2 topics of this machine until Ctrl-C.

Examples:
  setcmas simu --nb-robots 8
  setcmas simu --nb-robots 3 --pose 1:1.0,2.0,1.57 --limits burger
  setcmas simu --nb-robots 8 --robots 1-4        half of a fleet; the rest runs elsewhere
  setcmas simu --nb-robots 8 --rviz              shown in RViz 2; --view: in the browser
"""

from __future__ import annotations

import argparse

from launch_scripts.options.view_options import add_view_arguments, view_beside
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.node_arguments import node_arguments
from launch_scripts.processes.node_commands import SIMULATOR, SIMULATOR_OPTIONS, node_command
from setcmas_simu.simulator.options import add_simulation_arguments, simulated_robots


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_simulation_arguments(parser)
    add_view_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Simulate until Ctrl-C; returns the exit status."""
    if args.nb_robots is None and args.robots is None:
        args.nb_robots = 1
    simulated = simulated_robots(args)  # mistakes are told before anything starts
    require_ros()
    with view_beside(args, simulated.robots) as companions:
        command = node_command(SIMULATOR, node_arguments(args, SIMULATOR_OPTIONS))
        return run_in_foreground('simu', command, companions)
