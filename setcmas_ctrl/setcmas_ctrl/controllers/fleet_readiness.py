"""Readiness of a fleet: what must be there before the first step of its controllers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from setcmas_ctrl.controllers.controlled_fleet import ControlledFleet
from setcmas_ctrl.controllers.fleet_discovery import go_on, wait_until
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.reports import Started

_POLL_EVERY_S = 0.002
_AFTER_ODOMETRY_S = 0.02
_LISTENERS_WAIT_S = 2.0
_RECORDER_WAIT_S = 15.0  # enough for a machine that loads everything from disk first


def wait_until_ready(fleet: ControlledFleet) -> None:
    """Wait until all poses are known, the robots listen, and a recorder, if there is one.

    Raises:
        StopCall: The process was asked to stop meanwhile.
    """
    process, poses, graph = fleet.process, fleet.poses, fleet.monitor.graph
    _wait_for(fleet, 'odometry', poses.missing, poses.topic_of, partial(_odometry_hint, fleet))
    if fleet.controllers:
        state_of = partial(topics.robot_topic, topic=topics.TRIG_ODOM)
        _wait_for(fleet, 'states', fleet.network.missing, state_of, _sent_hint)
    # The robots, and a recorder if there is one, must get the very first command.
    process.spin_until(graph.all_connected(), _LISTENERS_WAIT_S)
    recorded = fleet.options.recorded
    wait_s = _RECORDER_WAIT_S if recorded else _LISTENERS_WAIT_S
    process.spin_until(graph.all_recorded(recorded), wait_s)
    if fleet.monitor.time_topic:
        fleet.monitor.time_topic.wait_for_others(process)
    go_on(not process.stopping)
    _report_start(fleet)  # not between the odometry and t = 0, as logging takes time
    _fall_in_step(fleet)
    fleet.monitor.note_step()
    fleet.driven.forget()


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
        fleet.node.get_logger().warning(f'{text}; {hint(robots)}')

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
    if not (fleet.controllers or fleet.driven.nodes):
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
