"""Readiness of a fleet: its robots, their clock, and all else that its controllers wait for."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from rclpy.node import Node

from setcmas_ctrl.controllers.controlled_fleet import ControlledFleet
from setcmas_ctrl.laws.script_errors import StopCall
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.reports import Started
from setcmas_simu.ros.clocks import ScaledClock, SteadyClock, TopicClock
from setcmas_simu.ros.fleet_node import SIMULATED_TIME, FleetNode
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import RosProcess

_ODOMETRY_TYPE = 'nav_msgs/msg/Odometry'
_SETTLED_S = 1.5
_FORGOTTEN_AFTER_S = 6.0  # one second more than the lease in config/fastdds_network.xml
_REMIND_EVERY_S = 2.0
_POLL_EVERY_S = 0.002
_AFTER_ODOMETRY_S = 0.02
_LISTENERS_WAIT_S = 2.0
_RECORDER_WAIT_S = 15.0  # enough for a machine that loads everything from disk first


def wait_for_fleet(
    process: RosProcess, node: FleetNode, listener: FleetListener, nb_robots: int | None = None
) -> int:
    """Wait until the robots of a fleet are announced, or publish odometry if none is announced.

    Returns:
        Size of the fleet, nb_robots if given.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    changed, seen = time.monotonic(), (0, [0])

    def is_known() -> bool:
        nonlocal changed, seen
        listener.take()
        robots = [] if listener.robots else _robots_with_odometry(node)
        if (len(listener.robots), robots) != seen:
            changed, seen = time.monotonic(), (len(listener.robots), robots)
        settled_s = time.monotonic() - changed
        # A killed process stays in the graph for a while and will not announce anything.
        if listener.robots:
            return listener.is_complete or settled_s >= _SETTLED_S
        if node.count_publishers(topics.FLEET):
            return bool(robots) and settled_s >= _FORGOTTEN_AFTER_S
        return bool(robots) and (len(robots) == nb_robots or settled_s >= _SETTLED_S)

    warn = node.get_logger().warning
    _wait_until(process, is_known, lambda: warn(_missing(node, nb_robots)))
    if not listener.robots:
        warn(
            f'nothing announces a fleet on {node.full_name(topics.FLEET)}: '
            f'{robots_in_words(seen[1], "are")} found by odometry, and treated as unicycles '
            'unless --model says otherwise'
        )
    return nb_robots or listener.nb_robots or max(seen[1])


def _robots_with_odometry(node: Node) -> list[int]:
    """Return the sorted numbers of robots with odometry publishers."""
    robots = [
        robot
        for name, types in node.get_topic_names_and_types()
        if _ODOMETRY_TYPE in types
        and (robot := topics.robot_of(name))
        and name == topics.odometry_topic(robot)
        and node.count_publishers(name)
    ]
    return sorted(robots)


def _missing(node: FleetNode, nb_robots: int | None) -> str:
    """Return what a controller waits for, and how to get it."""
    if nb_robots:
        robots = robots_in_words([*range(1, nb_robots + 1)])
        return (
            f'waiting for the odometry of {robots} ({topics.odometry_topic(1)}); is their '
            'simulator running?'
        )
    return (
        f'waiting for a fleet: nothing is announced on {node.full_name(topics.FLEET)}; is setcmas '
        'simu running in the same ROS domain and namespace?'
    )


def _wait_until(
    process: RosProcess, is_there: Callable[[], bool], remind: Callable[[], object]
) -> None:
    """Wait for something, and remind the user every 2 s; raise StopCall if asked to stop."""
    while not process.stopping and not process.spin_until(is_there, _REMIND_EVERY_S):
        if not process.stopping:
            remind()
            if process.requests:
                process.requests.start_services()  # the wait may be long
    if process.stopping:
        raise StopCall


def clock_of_robots(process: RosProcess, node: FleetNode, announced: FleetListener) -> SteadyClock:
    """Return the clock of the robots; wait for one on /clock.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    if announced.first.rtf != 1.0:
        return ScaledClock(announced.first.rtf, announced.first.begin)
    if not node.get_parameter(SIMULATED_TIME).value:
        return SteadyClock()
    clock = TopicClock(node)
    text = f'waiting for the time on {topics.CLOCK} ({SIMULATED_TIME}); is it published?'
    _wait_until(process, clock.has_begun, lambda: node.get_logger().warning(text))
    return clock


def wait_until_ready(fleet: ControlledFleet) -> None:
    """Wait until all poses are known, the robots listen, and a recorder, if there is one.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    process, poses, graph = fleet.process, fleet.poses, fleet.monitor.graph
    _wait_for(fleet, 'odometry', poses.missing, poses.topic_of, partial(_odometry_hint, fleet))
    if fleet.controllers:
        state_of = partial(topics.robot_topic, topic=topics.TRIG_ODOM)
        hint = 'is a controller running with --event-triggered?'
        _wait_for(fleet, 'states', fleet.network.missing, state_of, lambda _: hint)
    # The robots, and a recorder if there is one, must get the very first command.
    process.spin_until(graph.all_connected(), _LISTENERS_WAIT_S)
    recorded = fleet.options.recorded
    wait_s = _RECORDER_WAIT_S if recorded else _LISTENERS_WAIT_S
    process.spin_until(graph.all_recorded(recorded), wait_s)
    if fleet.monitor.time_topic:
        fleet.monitor.time_topic.wait_for_others(process)
    if process.stopping:
        raise StopCall
    _report_start(fleet)  # not between the odometry and t = 0, as logging takes time
    _fall_in_step(fleet)
    fleet.monitor.note_step()
    for follower in fleet.followers:
        follower.forget()


def _wait_for(
    fleet: ControlledFleet,
    what: str,
    missing: Callable[[], list[int]],
    topic_of: Callable[[int], str],
    hint: Callable[[list[int]], str],
) -> None:
    """Wait until no robot is missing; name those that are, now and then, with a hint."""

    def is_there() -> bool:
        fleet.take()
        return not missing()

    def remind() -> None:
        robots = missing()
        text = f'waiting for the {what} of {robots_in_words(robots)} ({topic_of(robots[0])})'
        fleet.node.get_logger().warning(f'{text}; {hint(robots)}')

    _wait_until(fleet.process, is_there, remind)


def _odometry_hint(fleet: ControlledFleet, robots: list[int]) -> str:
    for robot in robots:
        if fault := fleet.poses.fault(robot):
            return f'robot {robot} sends invalid odometry: {fault}'
    if fleet.options.experiment:
        return f'does motion capture see {"it" if len(robots) == 1 else "them"}?'
    return 'is the simulator running?'


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
