"""Run a control law on every robot of a running fleet until Ctrl-C.

Examples:
  setcmas ctrl --algo consensus
  setcmas ctrl --algo my_law --watch             reload it whenever you save it
  setcmas ctrl --algo my_law --set K=1.2         another gain for this run
  setcmas ctrl --algo nav_wp --nb-robots 8 --robots 5-8
  setcmas ctrl --algo consensus --event-triggered --graph ring
"""

from __future__ import annotations

import argparse

from launch_scripts.command_scenario import add_scenario_arguments, scenario_of
from launch_scripts.commands.view import NONE, ViewOptions, fleet_views, shown_robots
from launch_scripts.environment import require_ros
from launch_scripts.processes import CONTROLLER, add_ros_arguments
from launch_scripts.supervisor import run_node
from launch_scripts.terminal import warn
from setcmas_ctrl.laws.control_options import ControllerOptions, FleetOptions, WatchOptions


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_scenario_arguments(parser, parts=('law', 'communication', 'safety'))
    FleetOptions.add_to(parser, quiet=True)
    WatchOptions.add_to(parser)
    ViewOptions.add_to(parser, view=NONE)  # the simulator shows the robots already
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Control until Ctrl-C; return the exit status."""
    fleet, arguments = _prepared(args)
    robots = shown_robots(fleet.robots, fleet.nb_robots)
    require_ros()
    view = ViewOptions.of(args)
    with fleet_views(view, robots, ros_arguments=args.ros_args) as companions:
        return run_node(args, CONTROLLER, arguments, companions)


def _prepared(args: argparse.Namespace) -> tuple[FleetOptions, list[str]]:
    """Return the fleet, and the arguments of the node."""
    scenario = scenario_of(args)
    fleet = FleetOptions.among({**scenario.robots.values(), **FleetOptions.typed(args)})
    scenario.check()  # mistakes are found before anything starts
    for note in (*scenario.notes, *scenario.safety.notes):
        warn(f'setcmas ctrl: {note}')
    options = ControllerOptions(**fleet.values(), watch=args.watch)
    return fleet, scenario.law.arguments(scenario.communication, scenario.safety, options)
