"""Watch over the wheels of a robot: its motors are switched off if it does not obey zero."""

from __future__ import annotations

from setcmas_expe.bridge.bridge_decision import BridgeState, Decision, RobotView, Velocities
from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import (
    MOVES_M_S,
    RUNS_AWAY_AFTER_S,
    SLOWS_WITHIN_OVER_RADIO_S,
    Disobedience,
    Obedience,
)
from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_simu.fleet import topics
from setcmas_simu.ros.fleet_node import FleetNode

_RECENT_S = 0.5


class WheelWatch:
    """Compares what a robot is commanded with what it does, and switches its motors.

    Attributes:
        runs_away: Whether it ignored zero since its last report, which sets this to False.
    """

    def __init__(self, node: FleetNode, robot: LabRobot, lab: Lab, guard: GuardWatch) -> None:
        """Reach the motors of a robot through a node; its guard watches the wheels, too."""
        self.runs_away = False
        self._disobeys = ''  # since the last pause
        self._robot = robot.number
        self._logger = node.get_logger()
        self._guard = guard
        self._motors = MotorPower(node, robot.topic(topics.MOTOR_POWER))
        self._obedience = Obedience(lab.limits, SLOWS_WITHIN_OVER_RADIO_S)
        self._limits = lab.limits
        self._by_mocap = Obedience(lab.limits, RUNS_AWAY_AFTER_S)  # of a robot without odometry
        self._was_paused = False
        self._may_roll = False  # it has not stood since it was told to move; else it is carried

    def measure(self, V: float, omega: float, now: float) -> None:
        """Note the forward speed (m/s) and turn rate (rad/s) of the wheels at a time (s)."""
        self._obedience.measure(V, omega, now)

    def trouble(self, sent: Velocities, now: float) -> str:
        """Note the last command; return how the robot disobeys; empty if it obeys."""
        found = self._obedience.update(*sent, now)
        if found is Disobedience.IGNORES_ZERO or self._guard.found_deaf:
            self._cut_motors()
            # A robot that has come to rest has obeyed: a person pushes it.
            self.runs_away |= not self._obedience.came_to_rest
        elif self._guard.has_ended:  # its base keeps its last velocity
            self._motors.cut()
        self._motors.step(now)
        return found.value if found else self._disobeys

    def obey(self, decision: Decision, view: RobotView, now: float) -> None:
        """Switch the motors as decided: a start gives them power, whoever cut them."""
        if decision.state is BridgeState.PAUSED:
            self._disobeys, self._was_paused = '', True
            self._motors.leave()
        elif not (decision.why and decision.why.cause.lasts) and not self._guard.has_ended:
            if self._motors.is_cut or (self._was_paused and not self._guard.is_there()):
                self._motors.give()
            self._was_paused = False
        self._find_runaway(decision, view, now)

    def _find_runaway(self, decision: Decision, view: RobotView, now: float) -> None:
        """Cut the motors of a robot without odometry that motion capture sees moving on."""
        if now - view.rolled < _RECENT_S:
            return  # its wheels say whether it drives, or is carried
        commanded = decision.V, decision.omega
        self._may_roll |= any(commanded)
        if not view.pose_fault and now - view.measured < _RECENT_S:
            moves = self._limits.faster_wheel(*view.velocities) > MOVES_M_S
            self._by_mocap.measure(*(view.velocities if moves else (0.0, 0.0)), now)
            self._may_roll &= moves or any(commanded)
        has_rival = view.trouble is not None and view.trouble.cause.is_contest
        found = self._by_mocap.update(*commanded, now)
        if found is Disobedience.IGNORES_ZERO and (self._may_roll or has_rival):
            self._cut_motors()
            self.runs_away = True

    def _cut_motors(self) -> None:
        """Switch the motors off until the next start: the robot moves although commanded zero."""
        if not self._motors.is_cut:
            off = 'its motors are off until the next start'
            way = off if self._motors.can_switch else 'it has no motor_power: switch it off'
            self._logger.error(f'robot {self._robot} does not obey zero commands: {way}')
        self._motors.cut()
        self._disobeys = Disobedience.IGNORES_ZERO.value
