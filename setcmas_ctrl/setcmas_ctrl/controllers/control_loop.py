"""Loop of a process of controllers, and what must be there before its first step."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from functools import partial
from typing import Any

from setcmas_ctrl import drawing, network
from setcmas_ctrl.communication.communication_settings import CommunicationOptions
from setcmas_ctrl.controllers.controlled_fleet import ControlledFleet, Prepared
from setcmas_ctrl.controllers.fleet_discovery import (
    clock_of_robots,
    go_on,
    wait_for_fleet,
    wait_until,
)
from setcmas_ctrl.controllers.fleet_scripts import FleetScripts
from setcmas_ctrl.controllers.markers import MarkerCanvas
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.control_options import SCRIPT_FAILED, ControllerOptions, LawOptions
from setcmas_ctrl.laws.script_errors import StopCall
from setcmas_ctrl.script_outcomes import end_stuck_script
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.reports.reports import Started
from setcmas_simu.robot_node import RobotNode, stepping
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.parameters import NodeParameters
from setcmas_simu.ros.polling import RequestWait
from setcmas_simu.ros.process import FleetNode, RosProcess
from setcmas_simu.ros.step_loop import SteadyClock

_POLL_EVERY_S = 0.002
_AFTER_ODOMETRY_S = 0.02
_LISTENERS_WAIT_S = 2.0
_RECORDER_WAIT_S = 15.0  # enough for a machine that loads everything from disk first


def prepared_fleet(
    process: RosProcess,
    node: FleetNode,
    parameters: NodeParameters[LawOptions],
    communication: CommunicationOptions,
    safety: FilterOptions,
    options: ControllerOptions,
    alone: RobotNode | None = None,
    clock: SteadyClock | None = None,
) -> ControlledFleet:
    """Find a fleet, load its laws, and create the nodes of its robots in this process.

    Args:
        process: This process.
        node: Stands for the fleet: it has what there is once.
        parameters: Those of this node.
        communication: How the robots communicate.
        safety: The safety filter.
        options: Which robots there are, and how they listen.
        alone: The only node, if the others of its robot are in other processes.
        clock: Clock of the steps; by default that of the robots.

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
    nb_robots = max(nb_robots, alone.robot if alone else 0)  # it may come later
    robots = options.controlled(nb_robots)
    scripts = FleetScripts(process, node, law, found, communication, robots, nb_robots)
    if given and not options.experiment:  # laws load before there is a fleet
        wait_for_fleet(process, node, announced, given)
    clock = clock or clock_of_robots(process, node, announced)
    prepared = Prepared(announced, nb_robots, clock, scripts, alone)
    return ControlledFleet(process, node, parameters, safety, options, prepared)


def run_controllers(process: RosProcess, node: FleetNode, *given: Any) -> int:
    """Find a fleet and control its robots until the process must stop; return the exit status.

    The arguments and errors are those of `prepared_fleet`.
    """
    with drawing.drawn_on(MarkerCanvas(node)):
        try:
            return _control(prepared_fleet(process, node, *given))
        except StopCall:
            return 0


def _control(fleet: ControlledFleet) -> int:
    """Control the robots until the process must stop; then they rest. Return the exit status."""
    process = fleet.process
    process.take_signals()  # scripts may have changed the handlers while loading
    end_stuck_script(process, fleet.watch)
    try:
        with contextlib.suppress(StopCall), network.exchanged_by(fleet.network):
            _wait_until_ready(fleet)
            fleet.parameters.check = fleet.check
            fleet.set_rate(fleet.parameters.options.rate)

            def end_step() -> None:
                fleet.end_step()
                loop.poll = fleet.poll if fleet.polls_often else None

            loop = stepping(process, fleet.time, fleet.phases, fleet.begin_step, end_step)
            loop.run()
    finally:
        if process.can_talk:
            fleet.stop()
        fleet.watch.close()
    fleet.scripts.outcomes.end()
    return SCRIPT_FAILED if fleet.scripts.outcomes.failed else 0


def _wait_until_ready(fleet: ControlledFleet) -> None:
    """Wait until all poses are known, the robots listen, and a recorder, if there is one.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    process, poses, graph = fleet.process, fleet.poses, fleet.graph
    _wait_for(fleet, 'odometry', poses.missing, poses.topic_of, partial(_odometry_hint, fleet))
    if fleet.controllers:
        state_of = partial(topics.robot_topic, topic=topics.TRIG_ODOM)
        _wait_for(fleet, 'states', fleet.network.missing, state_of, _sent_hint)
    # The robots, and a recorder if there is one, must get the very first command.
    process.spin_until(graph.all_connected(), _LISTENERS_WAIT_S)
    recorded = fleet.options.recorded
    wait_s = _RECORDER_WAIT_S if recorded else _LISTENERS_WAIT_S
    process.spin_until(graph.all_recorded(recorded), wait_s)
    if fleet.time_topic:
        fleet.time_topic.wait_for_others(process)
    go_on(not process.stopping)
    _report_start(fleet)  # not between the odometry and t = 0, as logging takes time
    _fall_in_step(fleet)
    fleet.note_step()
    fleet.forget()


def _taken(fleet: ControlledFleet, missing: Callable[[], list[int]]) -> list[int]:
    fleet.take()
    return missing()


def _wait_for(
    fleet: ControlledFleet,
    what: str,
    missing: Callable[[], list[int]],
    topic_of: Callable[[int], str],
    hint: Callable[[list[int]], str],
) -> None:
    """Wait until no robot is missing; name those that are, now and then, with a hint."""

    def remind() -> None:
        robots = missing()
        text = f'waiting for the {what} of {robots_in_words(robots)} ({topic_of(robots[0])})'
        fleet.warn(f'{text}; {hint(robots)}')

    go_on(wait_until(fleet.process, lambda: not _taken(fleet, missing), remind))


def _odometry_hint(fleet: ControlledFleet, robots: list[int]) -> str:
    for robot in robots:
        if fault := fleet.poses.fault(robot):
            return f'robot {robot} sends invalid odometry: {fault}'
    if fleet.options.experiment:
        return f'does motion capture see {"it" if len(robots) == 1 else "them"}?'
    return 'is the simulator running?'


def _sent_hint(_: list[int]) -> str:
    return 'is a controller running with --event-triggered?'


def _report_start(fleet: ControlledFleet) -> None:
    paths = [one.law.path for one in fleet.controllers if one.law]
    law = ', '.join(dict.fromkeys(path.stem for path in paths)) or 'velocities of others'
    robots = robots_in_words(fleet.robots)
    task = f'controlling {robots} with {law} at {fleet.parameters.options.rate:g} Hz'
    if not (fleet.controllers or fleet.si_to_unis):
        task = f'sending the states of {robots} by events'
    fleet.node.get_logger().info(f'{task}; Ctrl-C stops')
    fleet.process.launcher.report(Started(tuple(fleet.robots), law))


def _fall_in_step(fleet: ControlledFleet) -> None:
    """Wait until shortly after the next odometry of a robot.

    Robots and laws step on clocks that run alike, at rates that divide each other, so that
    from then on every call sees fresh poses, and its commands arrive before the robots' next
    step.
    """
    process, clock = fleet.process, fleet.time.clock
    fleet.take()

    def is_new() -> bool:
        fleet.take()
        return fleet.poses.age(fleet.robots[0]) == 0.0

    process.spin_until(is_new, 1.0, _POLL_EVERY_S)
    begin = clock.now()
    process.spin_until(lambda: clock.now() - begin >= _AFTER_ODOMETRY_S, 1.0, _POLL_EVERY_S)
