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

from launch_scripts.commands.view_options import NONE, ViewOptions, view_beside
from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.node_commands import (
    CONTROLLER,
    add_ros_arguments,
    node_command,
    ros_arguments,
)
from launch_scripts.processes.rviz import shown_robots
from launch_scripts.terminal.terminal_output import warn
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.communication.communication_settings import check_communication
from setcmas_ctrl.control.control_options import FleetOptions, LawOptions
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_simu.robots.models import NO_LIMITS, check_models, model_names


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    LawOptions.add_to(parser)
    FleetOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    FilterOptions.add_to(parser)
    ViewOptions.add_to(parser, view=NONE)  # the simulator shows the robots already
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Control until Ctrl-C; returns the exit status."""
    law, fleet = LawOptions.of(args), FleetOptions.of(args)
    communication, safety = CommunicationOptions.of(args), FilterOptions.of(args)
    # Mistakes are told before anything starts.
    scripts = law.scripts()
    for note in (*scripts.notes, *safety.notes):
        warn(f'setcmas ctrl: {note}')
    if fleet.nb_robots:
        scripts.check(fleet.nb_robots)
        check_models(model_names(fleet.model, fleet.nb_robots), NO_LIMITS)
    robots = shown_robots(fleet.robots, fleet.nb_robots)
    check_communication(communication.found(law.exercise), fleet.nb_robots)
    require_ros()
    with view_beside(ViewOptions.of(args), robots) as companions:
        arguments = law.arguments() + fleet.arguments() + communication.arguments()
        arguments += safety.arguments()
        arguments += ros_arguments(args)
        return run_in_foreground('ctrl', node_command(CONTROLLER, arguments), companions)
