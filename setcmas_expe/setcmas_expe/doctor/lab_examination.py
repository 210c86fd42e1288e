"""Examination of a lab over ROS: every robot, and its nudge if wanted."""

from __future__ import annotations

from setcmas_expe.doctor.findings import NOTE, Finding
from setcmas_expe.doctor.lab_checks import COLUMNS, RobotCheck, other_presets
from setcmas_expe.doctor.lab_watch import LabWatch, round_trip
from setcmas_expe.doctor.nudge import Nudger
from setcmas_expe.lab.lab import Lab
from setcmas_expe.safety.body_proofs import Proofs
from setcmas_simu.ros.process import RosProcess

_DISCOVERY_S = 3.0
_EXPERIMENT = Finding(NOTE, 'experiment', 'one is running', 'end it (q in its terminal) to nudge')


class LabExamination:
    """What the doctor does in a lab."""

    def __init__(self, process: RosProcess, lab: Lab, proofs: Proofs | None) -> None:
        """Start to listen.

        Args:
            process: The process.
            lab: The lab.
            proofs: Keeps what nudges prove; None to keep nothing.
        """
        self._proofs = proofs
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
        proofs = None if self._watch.is_emulated() else self._proofs
        return list(Nudger(self._process, self._watch, proofs).findings())

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
