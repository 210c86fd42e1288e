"""The processes of controllers: of a whole fleet, or of one node of a robot.

ros2 run setcmas_ctrl controller --algo consensus
ros2 run setcmas_ctrl controller --ros-args -r __ns:=/tb3_3 -p nb_robots:=8 -p algo:=consensus
ros2 run setcmas_ctrl si_to_uni --ros-args -r __ns:=/tb3_3 -p komega:=2.0
ros2 run setcmas_ctrl event_triggered_comm --ros-args -r __ns:=/tb3_3
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from setcmas_ctrl import network
from setcmas_ctrl.communication.communication_options import CommunicationOptions
from setcmas_ctrl.controller import Controller
from setcmas_ctrl.controllers.controlled_fleet import ControlledFleet
from setcmas_ctrl.controllers.fleet_readiness import (
    clock_of_robots,
    wait_for_fleet,
    wait_until_ready,
)
from setcmas_ctrl.controllers.fleet_scripts import FleetScripts
from setcmas_ctrl.controllers.markers import MarkerCanvas
from setcmas_ctrl.controllers.script_reloader import ScriptReloader
from setcmas_ctrl.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import (
    EXTERNAL,
    SCRIPT_FAILED,
    ControllerOptions,
    GainOptions,
    LawOptions,
)
from setcmas_ctrl.laws.drawing import drawn_on
from setcmas_ctrl.laws.script_errors import StopCall
from setcmas_ctrl.laws.script_output import named_output
from setcmas_ctrl.laws.script_seeds import seeded_generators
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import check_in_fleet, robots_in_words
from setcmas_simu.robot_node import RobotNode, run_steps
from setcmas_simu.robots.model import IDEAL
from setcmas_simu.ros.clocks import SteadyClock
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.parameters import NodeParameters
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess, end_process, node_main

PARAMETERS = ('vnom', 'komega', 'rate')
"""The options that are parameters of the node of a fleet's process."""

Serve = Callable[[RosProcess, argparse.Namespace], int]


def main(argv: list[str] | None = None) -> int:
    """Control a fleet until a signal arrives; return the exit status."""
    return _run('controllers', LawOptions, _serve_fleet, argv)


def controller(argv: list[str] | None = None) -> int:
    """Run the controller of one robot, or with --algo all nodes; return the exit status."""
    words = sys.argv[1:] if argv is None else argv
    if any(word.partition('=')[0] == '--algo' for word in words):
        return main(argv)
    return _run_node('controller', argv)


def si_to_uni(argv: list[str] | None = None) -> int:
    """Run the si_to_uni of one robot until a signal arrives; return the exit status."""
    return _run_node('si_to_uni', argv)


def event_triggered_comm(argv: list[str] | None = None) -> int:
    """Run the event-triggered communication of one robot; return the exit status."""
    return _run_node('event_triggered_comm', argv)


def _run(name: str, gains: type[GainOptions], serve: Serve, argv: list[str] | None) -> int:
    parser = argparse.ArgumentParser(
        prog=name, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for group in (gains, ControllerOptions, CommunicationOptions, FilterOptions):
        group.add_to(parser)
    return node_main(parser, serve, argv)


def _serve_fleet(process: RosProcess, args: argparse.Namespace) -> int:
    node = FleetNode(topics.CONTROLLERS, follows_clock=True, enable_rosout=True)
    options = ControllerOptions.of(args)
    # Robots of an experiment stop when commands are late.
    fixed = ['rate'] if options.experiment else []
    parameters = NodeParameters(node, LawOptions.of(args), PARAMETERS, fixed)
    parameters.options = _law_of_parameters(node, parameters.options)
    communication, safety = CommunicationOptions.of(args), FilterOptions.of(args)
    options = _fleet_of_parameters(node, options)
    return run_controllers(process, node, parameters, communication, safety, options)


def _run_node(name: str, argv: list[str] | None) -> int:
    return _run(name, GainOptions, partial(_serve_node, name), argv)


def _serve_node(name: str, process: RosProcess, args: argparse.Namespace) -> int:
    gains, safety = GainOptions.of(args), FilterOptions.of(args)
    options = ControllerOptions.of(args)
    law = LawOptions(algo=EXTERNAL, **gains.values())
    node: RobotNode
    if name == 'controller':
        node = Controller(None, law, options.experiment)
    elif name == 'si_to_uni':
        node = SiToUni(None, law, safety, options, options.limits or IDEAL)
    else:
        node = EventTriggeredComm(None, options.experiment)
        args.event_triggered = True
    communication = CommunicationOptions.of(args)
    parameters = NodeParameters(node, law, ('rate',), ['rate'] * options.experiment)
    options = replace(_fleet_of_parameters(node, options), robots=(node.robot,))
    check_in_fleet([node.robot], options.nb_robots or node.robot, 'parameter robot_no')
    if isinstance(node, Controller):
        default = replace(parameters.options, algo='consensus')
        parameters.options = _law_of_parameters(node, default)
    elif isinstance(node, EventTriggeredComm):
        threshold = node.number('threshold', communication.threshold, 'as --threshold, in m')
        ctc = node.fixed('ctc', str(communication.ctc or ''), 'as --ctc')
        communication = replace(communication, threshold=threshold, ctc=ctc or None)
    return run_controllers(process, node, parameters, communication, safety, options)


def _law_of_parameters(node: FleetNode, law: LawOptions) -> LawOptions:
    """Declare parameters that say which law it is; return it, or raise SetcmasError."""
    algo = node.fixed('algo', str(law.algo), 'the control law')
    exercise = node.fixed('exercise', law.exercise, 'whether it is the exercise version')
    return replace(law, algo=algo, exercise=exercise)


def _fleet_of_parameters(node: FleetNode, options: ControllerOptions) -> ControllerOptions:
    """Declare a parameter with the size of the fleet; return the options, or raise SetcmasError.

    Its value 0 stands for the size that is announced.
    """
    size = node.fixed('nb_robots', options.nb_robots or 0, 'robots; 0: as announced')
    return replace(options, nb_robots=size or None)


def run_controllers(
    process: RosProcess,
    node: FleetNode,
    parameters: NodeParameters[LawOptions],
    communication: CommunicationOptions,
    safety: FilterOptions,
    options: ControllerOptions,
) -> int:
    """Prepare a fleet and control its robots until the process must stop; then they rest.

    The arguments and errors are those of `prepared_fleet`, but StopCall ends the process. `node`
    publishes what scripts draw, also while they load. Return the exit status.
    """
    canvas = MarkerCanvas(node)
    with seeded_generators(), named_output(), drawn_on(canvas):
        try:
            fleet = prepared_fleet(process, node, parameters, communication, safety, options)
        except StopCall:
            return 0
        canvas.clock = fleet.time.clock
        scripts = fleet.scripts
        process.take_signals()  # scripts may have changed the handlers while loading
        reloader = ScriptReloader(fleet) if fleet.options.watch and scripts.laws else None

        def step() -> None:
            fleet.step()
            if reloader:
                reloader.poll()

        try:
            with contextlib.suppress(StopCall), network.exchanged_by(fleet.network):
                wait_until_ready(fleet)
                fleet.follow_parameters()
                run_steps(process, fleet.time, step, fleet.poll)
        finally:
            if process.can_talk:
                fleet.stop()
            scripts.watch.close()
        scripts.report_end()
        return SCRIPT_FAILED if scripts.failed else 0


def prepared_fleet(
    process: RosProcess,
    node: FleetNode,
    parameters: NodeParameters[LawOptions],
    communication: CommunicationOptions,
    safety: FilterOptions,
    options: ControllerOptions,
    clock: SteadyClock | None = None,
) -> ControlledFleet:
    """Find a fleet, load its laws, and create the nodes of its robots in this process.

    The arguments are those of `ControlledFleet`; `communication` says how the robots communicate,
    and the clock is by default that of the robots.

    Raises:
        SetcmasError: A script does not load, or options contradict each other.
        StopCall: The process was asked to stop meanwhile.
    """
    if safety.is_on and options.robots and len(options.robots) != options.nb_robots:
        raise SetcmasError(
            'the safety filter needs all robots of the fleet in one process: add '
            f'--nb-robots {max(options.robots)} if {robots_in_words([*options.robots])} are all, '
            'leave out --robots, or add --filter none'
        )
    process.requests = RequestWait([node])
    law = parameters.options
    found = None if law.is_external else law.scripts()  # a missing script does not wait for robots
    communication = communication.found(law.exercise)
    announced, given = FleetListener(node), options.nb_robots
    nb_robots = given or wait_for_fleet(process, node, announced)
    if isinstance(node, RobotNode):
        nb_robots = max(nb_robots, node.robot)  # this robot may join later than the others
    robots = options.controlled(nb_robots)
    scripts = FleetScripts(process, node, law, found, communication, robots, nb_robots)
    if given and not options.experiment:  # laws load before there is a fleet
        wait_for_fleet(process, node, announced, given)
    clock = clock or clock_of_robots(process, node, announced)
    return ControlledFleet(process, node, parameters, safety, options, announced, scripts, clock)


if __name__ == '__main__':
    nodes = {one.__name__: one for one in (controller, si_to_uni, event_triggered_comm)}
    run = nodes.get(sys.argv[1]) if len(sys.argv) > 1 else None
    if run:
        del sys.argv[1]
    end_process((run or main)())
