"""Processes with one node of a robot; its other nodes are in other processes.

ros2 run setcmas_ctrl controller --ros-args -r __ns:=/tb3_3 -p nb_robots:=8 -p algo:=consensus
ros2 run setcmas_ctrl si_to_uni --ros-args -r __ns:=/tb3_3 -p komega:=2.0
ros2 run setcmas_ctrl event_triggered_comm --ros-args -r __ns:=/tb3_3
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from setcmas_ctrl.communication.communication_settings import CommunicationOptions
from setcmas_ctrl.controller import Controller
from setcmas_ctrl.controllers import controllers
from setcmas_ctrl.controllers.control_loop import run_controllers
from setcmas_ctrl.controllers.controllers import fleet_of_parameters, law_of_parameters
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import (
    EXTERNAL,
    ControllerOptions,
    GainOptions,
    LawOptions,
)
from setcmas_ctrl.laws.script_output import named_output
from setcmas_ctrl.laws.script_seeds import seeded_generators
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.fleet.fleet import check_in_fleet
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.robots.model import IDEAL
from setcmas_simu.ros.parameters import NodeParameters
from setcmas_simu.ros.process import RosProcess, node_main

Make = Callable[[LawOptions, FilterOptions, ControllerOptions], RobotNode]


def controller(argv: list[str] | None = None) -> int:
    """Run the controller of one robot, or with --algo all nodes; return the exit status."""
    words = sys.argv[1:] if argv is None else argv
    if any(word.partition('=')[0] == '--algo' for word in words):
        return controllers.main(argv)
    return _main('controller', lambda law, _, own: Controller(None, law, own.experiment), argv)


def si_to_uni(argv: list[str] | None = None) -> int:
    """Run the si_to_uni of one robot until a signal arrives; return the exit status."""

    def make(law: LawOptions, safety: FilterOptions, options: ControllerOptions) -> RobotNode:
        return SiToUni(None, law, safety, options, options.limits or IDEAL)

    return _main('si_to_uni', make, argv)


def event_triggered_comm(argv: list[str] | None = None) -> int:
    """Run the event-triggered communication of one robot; return the exit status."""
    return _main(
        'event_triggered_comm', lambda _, __, own: EventTriggeredComm(None, own.experiment), argv
    )


NODES = {
    'controller': controller,
    'si_to_uni': si_to_uni,
    'event_triggered_comm': event_triggered_comm,
}


def _main(name: str, make: Make, argv: list[str] | None) -> int:
    parser = argparse.ArgumentParser(
        prog=name, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    GainOptions.add_to(parser)
    ControllerOptions.add_to(parser)
    CommunicationOptions.add_to(parser)
    FilterOptions.add_to(parser)
    return node_main(parser, partial(_serve, make), argv)


def _serve(make: Make, process: RosProcess, args: argparse.Namespace) -> int:
    gains, safety = GainOptions.of(args), FilterOptions.of(args)
    options = ControllerOptions.of(args)
    law = LawOptions(algo=EXTERNAL, **gains.values())
    with seeded_generators(), named_output():
        node = make(law, safety, options)
        args.event_triggered |= isinstance(node, EventTriggeredComm)
        communication = CommunicationOptions.of(args)
        parameters = NodeParameters(node, law, {'rate': 'rate'})
        options = replace(fleet_of_parameters(node, options), robots=(node.robot,))
        check_in_fleet([node.robot], options.nb_robots or node.robot, 'parameter robot_no')
        if isinstance(node, Controller):
            default = replace(parameters.options, algo='consensus')
            parameters.options = law_of_parameters(node, default)
        elif isinstance(node, EventTriggeredComm):
            threshold = node.number('threshold', communication.threshold, 'as --threshold, in m')
            ctc = node.fixed('ctc', str(communication.ctc or ''), 'as --ctc')
            communication = replace(communication, threshold=threshold, ctc=ctc or None)
        return run_controllers(process, node, parameters, communication, safety, options, node)


if __name__ == '__main__':
    sys.exit(NODES[sys.argv.pop(1)]())
