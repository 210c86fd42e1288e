"""What the bridges of a fleet must share: the pause, where robots are, who has proved itself."""

from __future__ import annotations

from collections.abc import Mapping

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_ctrl.pause_watch import EmergencyWatch, PauseWatch
from setcmas_expe.bridge.bridge_decision import Decision, FleetView, RobotView, StopReason
from setcmas_expe.bridge.machine_load import StallDetector, time_since_boot, warn_of_load
from setcmas_expe.bridge.motion_watch import MotionWatch
from setcmas_expe.lab.lab import Lab
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.ros.fleet_node import FleetNode


class BridgedFleet:
    """Judges all robots of a lab together, and pauses them all if one stops for good."""

    def __init__(self, node: FleetNode, lab: Lab) -> None:
        """Listen to the pause and the stop through the node of the process."""
        self.warn = node.get_logger().warning
        self._pause = PauseWatch(node, lab.timeouts.pause_s, latches=True)
        self._emergency = EmergencyWatch(node)
        self._was_silent = True
        self._stalls = StallDetector(lab.timeouts.pause_s, time_since_boot())
        robots = [robot.number for robot in lab.robots] if lab.checks_motion else []
        self._motion = MotionWatch(robots, self.warn, node.get_logger().info)
        if not lab.checks_motion:
            self.warn('the check that robots move as commanded is off')

    def judge(self, views: Mapping[int, RobotView], now: float) -> FleetView:
        """Return what each bridge must know, from what each knows of its robot, by number."""
        self._look_for_stalls()
        pause = self._pause_reason()
        self._motion.see(views, now)
        allowed = {
            robot: self._motion.allowed(robot, *view.wanted) for robot, view in views.items()
        }
        return FleetView(pause, views, allowed, self._motion.deviations())

    def note(self, decisions: Mapping[int, Decision], now: float) -> None:
        """Note the decisions of a step: a robot that stopped for good pauses all of them."""
        is_paused = any(one.pause for one in decisions.values())
        commands = {robot: (one.V, one.omega) for robot, one in decisions.items()}
        self._motion.commanded({} if is_paused else commands, now)
        lasting: dict[StopReason, list[int]] = {}
        for robot, decision in decisions.items():
            if decision.why and decision.why.cause.lasts and not decision.pause:
                lasting.setdefault(decision.why, []).append(robot)
        if lasting:
            why, robots = next(iter(lasting.items()))
            each = ', each' if len(robots) > 1 else ''
            self._pause.latch(f'{robots_in_words(robots)}{each}: {why.text}')
            if why.cause.may_be_load:
                warn_of_load(self.warn)

    def _look_for_stalls(self) -> None:
        if stalled_for := self._stalls.tick(time_since_boot()):
            # Messages that waited look new, and a person may have come near a robot.
            self._pause.forget()
            self._motion.end_proofs()
            self.warn(f'the bridge process stalled for {stalled_for:.1f} s: robots stay paused')
            warn_of_load(self.warn)

    def _pause_reason(self) -> PauseReason | None:
        pause = self._pause.reason()
        is_silent = pause is not None and pause.cause is PauseCause.SILENT
        if is_silent and not self._was_silent:  # who else would say it?
            self.warn('all robots stopped: the pause node is silent')
            warn_of_load(self.warn)
        self._was_silent = is_silent
        if self._emergency.take():
            return PauseReason(PauseCause.EMERGENCY, PauseCause.EMERGENCY.value)
        return pause
