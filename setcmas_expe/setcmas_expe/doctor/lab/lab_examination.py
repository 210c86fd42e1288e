"""Examination of a lab over ROS: every robot, what is in its way, and its nudge if wanted."""

from __future__ import annotations

from setcmas_expe.doctor.findings import Finding
from setcmas_expe.doctor.lab.lab_watch import LabWatch
from setcmas_expe.doctor.lab.nudger import Nudger
from setcmas_expe.doctor.lab.robot_check import COLUMNS, RobotCheck
from setcmas_expe.doctor.lab.round_trip import round_trip
from setcmas_expe.lab.model import Lab
from setcmas_simu.fleet import topics
from setcmas_simu.ros.process import RosProcess

_DISCOVERY_S = 3.0


class LabExamination:
    """What the doctor does in a lab."""

    def __init__(self, process: RosProcess, lab: Lab) -> None:
        """Start to listen."""
        self._process = process
        self._lab = lab
        self._watch = LabWatch(lab)
        process.add(self._watch)

    def watch(self, seconds: float) -> None:
        """Wait until all robots are found, or cannot be; then listen for a while."""
        robots = self._watch.robots.values()
        self._process.spin_until(
            lambda: all(w.arrivals and self._watch.listeners(w.robot) for w in robots),
            _DISCOVERY_S,
        )
        self._watch.restart_statistics()
        self._process.spin_until(lambda: False, seconds)

    def result(self) -> tuple[tuple[str, ...], list[list[str]], list[Finding]]:
        """Return columns and rows of the table of robots, and what was found."""
        checks = self._checks()
        bodies = self._watch.mocap.bodies()
        findings = [f for check in checks for f in check.findings(self._lab, bodies)]
        return COLUMNS, [check.row() for check in checks], findings

    def nudge(self) -> list[Finding]:
        """Nudge the robots one after the other; returns what that proves."""
        self._process.spin_until(lambda: False, 0.2)  # what came while the user was asked
        return list(Nudger(self._process, self._watch).findings())

    def _checks(self) -> list[RobotCheck]:
        # Questions to robots take time: what was measured before is not to suffer from it.
        statistics = {number: self._watch.statistics(number) for number in self._watch.robots}
        poses = self._watch.poses()
        return [
            RobotCheck(
                watch.robot,
                statistics[number],
                poses.get(number),
                self._watch.fault(number),
                [one.kind for one in self._watch.listeners(watch.robot)],
                self._watch.rival(watch.robot, topics.CMD_VEL_BRIDGE_NODE),
                self._watch.is_guarded(watch.robot),
                watch.battery,
                round_trip(self._process, self._watch, watch.robot),
            )
            for number, watch in self._watch.robots.items()
        ]
