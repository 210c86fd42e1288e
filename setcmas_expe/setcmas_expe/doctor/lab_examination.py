"""Examinations over ROS: other fleets in sight, and a lab with its robots."""

from __future__ import annotations

from collections import defaultdict

from rclpy.node import Node

from setcmas_expe.doctor.findings import NOTE, OK, Finding
from setcmas_expe.doctor.lab_checks import COLUMNS, RobotCheck, other_presets
from setcmas_expe.doctor.lab_watch import LabWatch, round_trip
from setcmas_expe.doctor.nudge import Nudger
from setcmas_expe.lab.lab import Lab
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.process import RosProcess

_WHAT = 'other fleets'


def fleets_finding(node: Node, announced: FleetListener) -> Finding:
    """Return the robots in sight: announced ones, and others by the sender of their odometry."""
    fleets = {str(one.source): set(one.robots) for one in announced.take().values()}
    for sender, robots in _by_odometry(node).items():
        if others := robots.difference(*fleets.values()):
            fleets[sender] = others
    if not fleets:
        return Finding(OK, _WHAT, 'none in sight in this ROS domain')
    found = '; '.join(
        f'{robots_in_words(sorted(robots))} of {sender}' for sender, robots in fleets.items()
    )
    advice = (
        'if they are not yours, set another ROS_DOMAIN_ID (0 to 101), the same on your machines '
        'and robots'
    )
    return Finding(NOTE, _WHAT, found, advice)


def _by_odometry(node: Node) -> dict[str, set[int]]:
    senders: defaultdict[str, set[int]] = defaultdict(set)
    for name, _ in node.get_topic_names_and_types():
        robot = topics.robot_of(name)
        if robot and name == topics.robot_topic(robot, topics.ODOM):
            for info in node.get_publishers_info_by_topic(name):
                senders[info.node_name].add(robot)
    return senders


_DISCOVERY_S = 3.0
_EXPERIMENT = Finding(NOTE, 'experiment', 'one is running', 'end it (q in its terminal) to nudge')


class LabExamination:
    """What the doctor does in a lab."""

    def __init__(self, process: RosProcess, lab: Lab) -> None:
        """Start to listen."""
        self._process = process
        self._lab = lab
        self._watch = LabWatch(lab)
        process.add(self._watch)

    def watch(self, seconds: float) -> None:
        """Wait until all robots are discovered, with a limit; then listen for a while."""
        robots = self._watch.robots.values()
        self._process.spin_until(
            lambda: all(w.arrivals and self._watch.listeners(w.robot) for w in robots),
            _DISCOVERY_S,
        )
        self._watch.restart_statistics()
        self._process.spin_until(lambda: False, seconds)

    def result(self) -> tuple[tuple[str, ...], list[list[str]], list[Finding]]:
        """Return columns and rows of the table of robots, and the findings."""
        checks = self._checks()
        bodies = self._watch.mocap.bodies()
        findings = [f for check in checks for f in check.findings(self._lab, bodies)]
        if not bodies:
            graph = self._watch.get_topic_names_and_types()
            findings += other_presets(graph, self._lab.mocap.preset)
        if self._watch.runs_experiment():
            findings.insert(0, _EXPERIMENT)
        return COLUMNS, [check.row() for check in checks], findings

    def nudge(self) -> list[Finding]:
        """Nudge the robots one after the other, and return the results."""
        self._process.spin_until(lambda: False, 0.2)  # messages that came during the question
        return list(Nudger(self._process, self._watch).findings())

    def _checks(self) -> list[RobotCheck]:
        # Take the statistics first: questions to robots take time.
        self._watch.take_guards()
        statistics = {number: self._watch.statistics(number) for number in self._watch.robots}
        poses = self._watch.poses()
        return [
            RobotCheck(
                watch.robot,
                statistics[number],
                poses.get(number),
                self._watch.fault(number),
                [one.kind for one in self._watch.listeners(watch.robot)],
                self._watch.rival(watch.robot, experiment=True),
                self._watch.robot_guards[number].recent_report,
                watch.battery,
                round_trip(self._process, self._watch, watch.robot),
            )
            for number, watch in self._watch.robots.items()
        ]
