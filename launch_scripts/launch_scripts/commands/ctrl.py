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
from launch_scripts.commands.view import NONE, ViewOptions, fleet_views
from launch_scripts.environment import require_ros
from launch_scripts.processes import CONTROLLER, add_ros_arguments
from launch_scripts.supervisor import run_node
from launch_scripts.terminal import warn
from setcmas_ctrl.laws.control_options import ControllerOptions, FleetOptions, WatchOptions

_SHOWN = 8  # robots in RViz 2, where it is not known how many there are


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_scenario_arguments(parser, parts=('law', 'communication', 'safety'))
    FleetOptions.add_to(parser, quiet=True)
    WatchOptions.add_to(parser)
    ViewOptions.add_to(parser, view=NONE)  # the simulator shows the robots already
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Control until Ctrl-C; return the exit status."""
    scenario = scenario_of(args)
    fleet = FleetOptions.among({**scenario.robots.values(), **FleetOptions.typed(args)})
    scenario.check()  # mistakes are found before anything starts
    for note in (*scenario.notes, *scenario.safety.notes):
        warn(f'setcmas ctrl: {note}')
    options = ControllerOptions(**fleet.values(), watch=args.watch)
    require_ros()
    laws = scenario.law.arguments(scenario.communication, scenario.safety, options)
    # The number of robots is that of the running fleet, unless it is given.
    robots = list(fleet.robots or range(1, (fleet.nb_robots or _SHOWN) + 1))
    with fleet_views(ViewOptions.of(args), robots, ros_arguments=args.ros_args) as views:
        return run_node(args, CONTROLLER, laws, views)
