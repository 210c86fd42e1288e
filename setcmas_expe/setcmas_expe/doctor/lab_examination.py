"""Checks over ROS: other fleets in sight, and the robots of a lab."""

from __future__ import annotations

from collections import defaultdict

from rclpy.node import Node

from setcmas_expe.doctor.findings import NOTE, OK, Finding
from setcmas_expe.doctor.lab_checks import RobotCheck, other_presets
from setcmas_expe.doctor.lab_watch import LabWatch
from setcmas_expe.lab.lab import Lab
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import FleetNode, RosProcess

_SIGHT_S = 2.0
_DISCOVERY_S = 3.0
_WATCH_S = 3.0


def other_fleets(process: RosProcess) -> Finding:
    """Return the robots in sight: announced ones, and others by the sender of their odometry."""
    node = FleetNode('doctor')
    announced = FleetListener(node)
    process.add(node)
    process.spin_until(lambda: False, _SIGHT_S)
    fleets = {str(one.source): set(one.robots) for one in announced.take().values()}
    for sender, robots in _by_odometry(node).items():
        if others := robots.difference(*fleets.values()):
            fleets[sender] = others
    if not fleets:
        return Finding(OK, 'other fleets', 'none in sight in this ROS domain')
    found = '; '.join(
        f'{robots_in_words(sorted(robots))} of {sender}' for sender, robots in fleets.items()
    )
    advice = (
        'if they are not yours, set another ROS_DOMAIN_ID (0 to 101), the same on your machines '
        'and robots'
    )
    return Finding(NOTE, 'other fleets', found, advice)


def _by_odometry(node: Node) -> dict[str, set[int]]:
    senders: defaultdict[str, set[int]] = defaultdict(set)
    for name, _ in node.get_topic_names_and_types():
        robot = topics.robot_of(name)
        if robot and name == topics.robot_topic(robot, topics.ODOM):
            for info in node.get_publishers_info_by_topic(name):
                senders[info.node_name].add(robot)
    return senders


def watched_lab(process: RosProcess, lab: Lab) -> LabWatch:
    """Return a watch that has listened for a while, once it found all robots or waited enough."""
    watch = LabWatch(lab)
    process.add(watch)
    robots = watch.robots.values()
    process.spin_until(
        lambda: all(one.arrivals and watch.listeners(one.robot) for one in robots), _DISCOVERY_S
    )
    watch.restart_statistics()
    process.spin_until(lambda: False, _WATCH_S)
    return watch


def examine(watch: LabWatch) -> tuple[list[list[str]], list[Finding]]:
    """Return the rows of the table of robots, and the findings."""
    watch.take_guards()
    poses = watch.poses()
    checks = [
        RobotCheck(
            robot=one.robot,
            mocap=watch.statistics(number),
            pose=poses.get(number),
            fault=watch.fault(number),
            kinds=[listener.kind for listener in watch.listeners(one.robot)],
            rival=watch.rival(one.robot),
            guard=watch.robot_guards[number].recent_report,
            battery=one.battery,
        )
        for number, one in watch.robots.items()
    ]
    bodies = watch.mocap.bodies()
    findings = [found for check in checks for found in check.findings(watch.lab, bodies)]
    if not bodies:
        findings += other_presets(watch.get_topic_names_and_types(), watch.lab.mocap.preset)
    if watch.runs_experiment():
        findings.insert(0, Finding(NOTE, 'experiment', 'one is running'))
    return [check.row() for check in checks], findings
