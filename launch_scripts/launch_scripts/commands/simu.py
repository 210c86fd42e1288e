"""Simulate a fleet of robots on ROS 2 topics of this machine until Ctrl-C.

Examples:
  setcmas simu --nb-robots 8
  setcmas simu --nb-robots 3 --pose 1:1.0,2.0,1.57 --limits burger
  setcmas simu --nb-robots 8 --robots 1-4        half of a fleet; the rest runs elsewhere
  setcmas simu --nb-robots 8 --rviz              shown in RViz 2; --view: in the browser
"""

from __future__ import annotations

import argparse
from dataclasses import replace

from launch_scripts.commands.view_options import ViewOptions, view_beside
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.node_commands import (
    SIMULATOR,
    add_ros_arguments,
    node_command,
    ros_arguments,
)
from setcmas_simu.simulator.simulator_options import SimulationOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    SimulationOptions.add_to(parser)
    ViewOptions.add_to(parser)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Simulate until Ctrl-C; returns the exit status."""
    options = SimulationOptions.of(args)
    simulated = options.simulated()  # mistakes are told before anything starts
    require_ros()
    with view_beside(ViewOptions.of(args), simulated.robots) as companions:
        options = replace(options, nb_robots=options.fleet_size)
        command = node_command(SIMULATOR, options.arguments() + ros_arguments(args))
        return run_in_foreground('simu', command, companions)
