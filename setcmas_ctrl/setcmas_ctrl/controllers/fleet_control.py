"""Run of a process of controllers: finds the fleet, loads its laws, and steps their nodes."""

from __future__ import annotations

import contextlib
from typing import Any

from setcmas_ctrl import network
from setcmas_ctrl.communication.communication_settings import CommunicationOptions
from setcmas_ctrl.controllers.controlled_fleet import ControlledFleet
from setcmas_ctrl.controllers.fleet_discovery import clock_of_robots, wait_for_fleet
from setcmas_ctrl.controllers.fleet_readiness import wait_until_ready
from setcmas_ctrl.controllers.fleet_scripts import FleetScripts
from setcmas_ctrl.controllers.markers import MarkerCanvas
from setcmas_ctrl.controllers.script_reloader import ScriptReloader
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import SCRIPT_FAILED, ControllerOptions, LawOptions
from setcmas_ctrl.laws.drawing import drawn_on
from setcmas_ctrl.laws.script_errors import StopCall
from setcmas_simu.robot_node import RobotNode, run_nodes
from setcmas_simu.ros.clocks import SteadyClock
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.parameters import NodeParameters
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import RosProcess


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


def run_controllers(process: RosProcess, node: FleetNode, *given: Any) -> int:
    """Find a fleet and control its robots until the process must stop; return the exit status.

    The arguments and errors are those of `prepared_fleet`.
    """
    canvas = MarkerCanvas(node)
    with drawn_on(canvas):
        try:
            fleet = prepared_fleet(process, node, *given)
            canvas.clock = fleet.time.clock
            return _control(fleet)
        except StopCall:
            return 0


def _control(fleet: ControlledFleet) -> int:
    """Control the robots until the process must stop; then they rest. Return the exit status."""
    process, scripts = fleet.process, fleet.scripts
    process.take_signals()  # scripts may have changed the handlers while loading
    has_reloader = fleet.options.watch and scripts.laws
    reloader = ScriptReloader(fleet) if has_reloader else None

    def end_step() -> None:
        fleet.end_step()
        if reloader:
            reloader.poll()

    try:
        with contextlib.suppress(StopCall), network.exchanged_by(fleet.network):
            wait_until_ready(fleet)
            fleet.follow_parameters()
            run_nodes(process, fleet.time, fleet.phases, fleet.begin_step, end_step, fleet.poll)
    finally:
        if process.can_talk:
            fleet.stop()
        scripts.watch.close()
    scripts.outcomes.end()
    return SCRIPT_FAILED if scripts.outcomes.failed else 0
