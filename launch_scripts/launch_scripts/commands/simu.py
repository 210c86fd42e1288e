"""Simulate a fleet of robots on ROS 2 topics of this machine until Ctrl-C.

Examples:
  setcmas simu --nb-robots 8
  setcmas simu --nb-robots 3 --pose 1:1.0,2.0,1.57 --limits burger
  setcmas simu --nb-robots 8 --robots 1-4        half of a fleet; simulate the rest elsewhere
  setcmas simu --nb-robots 8 --view              show it in the browser; with --view rviz in RViz 2
"""

from __future__ import annotations

import argparse
from dataclasses import replace

from launch_scripts.command_scenario import add_scenario_arguments, scenario_of
from launch_scripts.commands.view import ViewOptions, fleet_views
from launch_scripts.environment import require_ros
from launch_scripts.processes import SIMULATOR, add_ros_arguments
from launch_scripts.supervisor import run_node
from setcmas_simu.option_groups import typed_words
from setcmas_simu.simulation_options import SimulationOptions
from setcmas_tools.run.scenario import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_scenario_arguments(parser, without=('duration',), parts=('robots', 'time'))
    of_scenario = [name for name in SimulationOptions.options() if name in options()]
    SimulationOptions.add_to(parser, without=of_scenario)
    ViewOptions.add_to(parser)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Simulate until Ctrl-C; return the exit status."""
    own = {'robots': args.robots, 'cmd_vel_type': args.cmd_vel_type}
    scenario = scenario_of(args, needs_law=False)
    values = {k: v for k, v in scenario.values().items() if k in SimulationOptions.options()}
    with typed_words():
        given = SimulationOptions(**own, **values)
    simulated = given.simulated()  # mistakes are reported before anything starts
    require_ros()
    view = ViewOptions.of(args)
    with fleet_views(view, simulated.robots, ros_arguments=args.ros_args) as views:
        arguments = replace(given, nb_robots=given.fleet_size).arguments()
        return run_node(args, SIMULATOR, arguments, views)
