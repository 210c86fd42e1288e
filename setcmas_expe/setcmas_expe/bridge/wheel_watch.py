"""Watch over the wheels of a robot: its motors are switched off if it does not obey zero."""

from __future__ import annotations

from setcmas_expe.bridge.decision import Decision, RobotView, State, Velocities
from setcmas_expe.guard.guard_decision import GuardState
from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import (
    IGNORES_ZERO,
    SLOWS_WITHIN_OVER_RADIO_S,
    Obedience,
    Runaways,
)
from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_simu.fleet import topics
from setcmas_simu.ros.process import FleetNode

_RECENT_S = 0.5


class WheelWatch:
    """Compares what a robot is commanded with what it does, and switches its motors.

    Attributes:
        disobeys: How it disobeys, since the last pause; empty if it obeys.
    """

    def __init__(self, node: FleetNode, robot: LabRobot, lab: Lab, guard: GuardWatch) -> None:
        """Reach the motors of a robot through a node; its guard watches the wheels, too."""
        self.disobeys = ''
        self._robot = robot.number
        self._logger = node.get_logger()
        self._guard = guard
        self._motors = MotorPower(node, robot.topic(topics.MOTOR_POWER))
        self._obedience = Obedience(lab.limits, SLOWS_WITHIN_OVER_RADIO_S)
        self._runaways = Runaways(lab.limits)
        self._was_paused = self._told_unguarded = False

    def measure(self, V: float, omega: float, now: float) -> None:
        """Note the forward speed (m/s) and turn rate (rad/s) of the wheels at a time (s)."""
        self._obedience.measure(V, omega, now)

    def trouble(self, sent: Velocities, now: float) -> str:
        """Note the last command; return how the robot disobeys; empty if it obeys."""
        found = self._obedience.update(*sent, now)
        report = self._guard.recent_report
        if found == IGNORES_ZERO or (report and report.state is GuardState.DEAF):
            self._cut_motors()
        elif self._guard.has_ended:  # its base keeps its last velocity
            self._motors.cut()
        self._motors.step(now)
        return found or self.disobeys

    def obey(self, decision: Decision, view: RobotView, now: float) -> None:
        """Switch the motors as decided: a start gives them power, whoever cut them."""
        if decision.state is State.PAUSED:
            self.disobeys, self._was_paused = '', True
            self._motors.leave()
        elif not (decision.why and decision.why.cause.lasts) and not self._guard.has_ended:
            if self._motors.is_cut or (self._was_paused and not self._guard.is_there()):
                self._motors.give()
            if not self._guard.is_there() and not self._told_unguarded:
                self._told_unguarded = True
                text = 'without a cmd_vel_guard it keeps its last velocity if this computer or its'
                self._logger.warning(f'robot {self._robot}: {text} network dies')
            self._was_paused = False
        self._find_runaway(decision, view, now)

    def _find_runaway(self, decision: Decision, view: RobotView, now: float) -> None:
        """Cut the motors of a robot that motion capture sees moving on against zero."""
        is_zero = decision.V == decision.omega == 0.0
        is_seen = not view.pose_fault and now - view.measured < _RECENT_S
        seen = view.velocities if is_seen else (0.0, 0.0)
        wheels = view.wheels if now - view.rolled < _RECENT_S else None
        has_rival = view.trouble is not None and view.trouble.cause.is_contest
        if self._runaways.update(self._robot, is_zero, seen, wheels, has_rival, now):
            self._logger.error(
                f'robot {self._robot} still moves ({self._runaways.robots[self._robot]:.2f} m/s) '
                'despite zero commands: switch it off'
            )
        if self._robot in self._runaways.robots:
            self._cut_motors()

    def _cut_motors(self) -> None:
        """Switch the motors off until the next start: the robot moves although commanded zero."""
        if not self._motors.is_cut:
            off = 'its motors are off until the next start'
            way = off if self._motors.can_switch else 'it has no motor_power: switch it off'
            self._logger.error(f'robot {self._robot} does not obey zero: {way}')
        self._motors.cut()
        self.disobeys = IGNORES_ZERO
