"""The cmd_vel bridge: a node that sends a real robot the command of its controller, or zero.

`setcmas expe` has those of all robots in one process (`bridges.py`).
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from setcmas_expe.bridge.bridge_decision import (
    ZERO,
    BridgeState,
    Cause,
    Decision,
    FleetView,
    RobotView,
    StopReason,
    Velocities,
    decide,
)
from setcmas_expe.bridge.bridge_report import BridgeReport
from setcmas_expe.guard.guard_watch import GuardWatch, diagnostic_status, diagnostic_values
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import (
    MOVES_M_S,
    RUNS_AWAY_AFTER_S,
    SLOWS_WITHIN_OVER_RADIO_S,
    Disobedience,
    Obedience,
)
from setcmas_expe.lab.lab import LOW_PERCENT, BatteryScale, Lab, LabRobot
from setcmas_simu.fleet import topics
from setcmas_simu.robot_node import RobotNode, StepTime
from setcmas_simu.ros import cmd_vel_topics, messages, qos
from setcmas_simu.ros.cmd_vel_topics import KILLED, CmdVelPublisher, NameWait, velocities
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.messages import state_of

_LOOK_EVERY_S = 0.5
_OVER_AFTER_S = 0.5  # a robot at the border comes and goes
_RECENT_S = 0.5  # age of poses and odometry that show what wheels do


class CmdVelBridge(RobotNode):
    """Sends robot i its command: cmd_vel_wanted and mocap/tb3_i/odom in, cmd_vel out.

    SiToUni and MocapBridge publish these inputs.
    A step has two halves, because robots must not collide: `look` returns what this bridge knows
    of its robot; `command` gets what `BridgedFleet` decides from what all bridges know.

    Attributes:
        lab: The lab.
        topic: Full name of the topic that the robot listens to.
        view: What was known of the robot at the last step.
        trouble_in_graph: Why its topics are not reliable; None if they are.
        wheel_watch: Whether its wheels obey.
        sent: The last command, V in m/s and omega in rad/s.
    """

    def __init__(self, robot: LabRobot, lab: Lab, fleet: FleetNode, step_time: StepTime) -> None:
        """Create the topics of a robot; `fleet` stands for this process."""
        name, number = topics.CMD_VEL_BRIDGE, robot.number
        super().__init__(name, number, fleet, step_time, follows_clock=False)
        self.lab, self.topic = lab, robot.topic(topics.CMD_VEL)
        self.wanted = self.newest(TwistStamped, topics.CMD_VEL_WANTED, qos.COMMAND)
        self.odom = self.newest(Odometry, topics.mocap_topic(self.robot))
        self.pose_state = self.newest(DiagnosticStatus, topics.pose_state_topic(self.robot))
        self.wheels = self.newest(Odometry, robot.topic(topics.ODOM), qos.SENSOR)
        self.battery = self.newest(BatteryState, robot.topic(topics.BATTERY), qos.SENSOR)
        self.guard = GuardWatch(self, robot.namespace)
        self.cmd_vel = robot_commands(self, robot)
        self.wheel_watch = WheelWatch(self, robot, lab, self.guard)
        self.state = self.create_publisher(DiagnosticStatus, topics.BRIDGE_STATE, qos.STATE)

        pause = self.full_name(f'/{topics.PAUSE_NODE}')  # it only commands zero
        self._may_command = (self.get_fully_qualified_name(), pause)
        self._sole = [
            (topics.robot_topic(self.robot, topics.CMD_VEL_WANTED), 'controllers command it'),
            (topics.robot_topic(self.robot, topics.CMD_CART_VEL), 'nodes command it'),
            (topics.robot_topic(self.robot, topics.CMD_CART_VEL_ALLOWED), 'nodes command it'),
            (topics.mocap_topic(self.robot), 'nodes send its poses'),
            (topics.pose_state_topic(self.robot), 'nodes judge its poses'),
            (robot.topic(topics.ODOM), 'nodes send its wheel odometry'),
        ]
        self._battery_scale = BatteryScale()
        self.view = RobotView(self.robot)
        self.trouble_in_graph: StopReason | None = None
        self._names = NameWait()
        self.sent = (0.0, 0.0)
        self._next_look, self._looked = 0.0, -math.inf
        self._warned_of: Cause | None = None  # why it stopped for a while
        self._warned_at = -math.inf

    def look(self) -> RobotView:
        """Take all news of the robot; return what is known of it now."""
        now = self.time.now
        if now >= self._next_look:
            self._next_look = now + _LOOK_EVERY_S
            self.trouble_in_graph = self._look_around()
        view = self.view
        if odom := self.odom():
            view = _seen(view, odom, now)
        if state := self.pose_state():
            is_accepted = state.level == DiagnosticStatus.OK
            fault = '' if is_accepted else state.message or Cause.POSE_REJECTED.value
            view = replace(view, pose_fault=fault, judged=now, height=_height(state))
        if command := self.wanted():
            # As old as the last look: it came some time after it.
            view = replace(view, wanted=velocities(command), commanded=self._looked)
        odometry = self.wheels()
        wheels = velocities(odometry.twist.twist) if odometry else None
        if wheels and all(map(math.isfinite, wheels)):
            view = replace(view, rolled=now)
        if battery := self.battery():
            percent = self._battery_scale.percent(battery.percentage)
            view = replace(view, charge=math.nan if percent is None else percent)
        self.guard.take(now)
        if view.charge < LOW_PERCENT:
            text = f'the battery of robot {self.robot} is at {view.charge:.0f} %: charge it'
            self.warn_once('battery', text)
        disobeys = self.wheel_watch.judge(wheels, self.sent, now)
        self._looked, self.view = now, replace(view, trouble=self._trouble(disobeys))
        return self.view

    def command(self, fleet: FleetView) -> Decision:
        """Decide on what is known, and send the robot its command; return the decision."""
        decision = decide(self.view, fleet, self.lab, self.time.now)
        self._send(decision)
        self.wheel_watch.switch(decision, self.view, self.time.now)
        self._warn_of(decision)
        return decision

    def report(self, decision: Decision) -> DiagnosticStatus:
        """Publish the state of the robot: OK, WARN (stopped) or ERROR (lost); return it."""
        is_moving = decision.state is BridgeState.MOVING
        level = DiagnosticStatus.OK if is_moving else DiagnosticStatus.WARN
        runs_away = self.wheel_watch.runs_away
        self.wheel_watch.runs_away = False
        if runs_away or (decision.why and decision.why.cause.is_blind):
            level = DiagnosticStatus.ERROR
        view, age = self.view, self.time.now - self.view.measured
        report = BridgeReport.of(
            decision,
            name=topics.robot_name(self.robot),
            level=ord(level),
            runs_away=runs_away,
            pose_age=round(age, 3) if math.isfinite(age) else None,
            battery=round(view.charge) if math.isfinite(view.charge) else None,
            speed=round(view.velocities[0], 3) if age <= self.lab.timeouts.pose_s else None,
        )
        name, text = report.name, report.reason
        message = diagnostic_status(level, name, text, self.topic, report.values)
        self.state.publish(message)
        return message

    def stop(self) -> None:
        """Command zero."""
        self._send(ZERO)

    def _trouble(self, disobeys: str) -> StopReason | None:
        """Return why the robot is not reliable, or how it disobeys; None if it is reliable."""
        if intruder := self.guard.intruder:
            return StopReason(Cause.PAST_GUARD, intruder)
        if self.trouble_in_graph:
            return self.trouble_in_graph
        if reason := self.guard.trouble(self.lab.guarded, self.lab.lidar_stop):
            cause = Cause.GUARD if self.guard.is_there() else Cause.GUARD_SILENT
            return StopReason(cause, reason)
        return StopReason(Cause.DEAF, disobeys) if disobeys else None

    def _look_around(self) -> StopReason | None:
        """Return who else commands the robot or sends its messages, or that it is deaf."""
        listens = self.cmd_vel.follow_listeners()
        self.guard.look_around()
        rivals = cmd_vel_topics.rivals(self, self.topic, *self._may_command)
        if self._names.is_on(rivals, self.time.now):
            self._next_look = self.time.now
            return self.trouble_in_graph
        if contest := cmd_vel_topics.contest(self, self.topic, rivals):
            return StopReason(Cause.RIVAL, contest)
        for topic, what in self._sole:
            if (found := self.count_publishers(topic)) > 1:
                return StopReason(Cause.RIVAL, f'{found} {what} ({topic}; {KILLED})')
        if not listens:
            nothing = (
                f'nothing listens to {self.topic}: is its bringup running in this ROS domain?'
            )
            return StopReason(Cause.DEAF, self.cmd_vel.mixed or nothing)
        return None

    def _send(self, decision: Decision) -> None:
        self.sent = decision.V, decision.omega
        since = min(self.view.driven_since, self.time.now) if any(self.sent) else math.inf
        self.view = replace(self.view, driven_since=since)
        self.cmd_vel.publish(*self.sent)

    def _warn_of(self, decision: Decision) -> None:
        """Show once why the robot stops for a while; the pause node shows what lasts."""
        now, why = self.time.now, decision.why
        if why and why.cause is Cause.POSE_LATE:  # known only after the pause
            self.warn_once('late', f'robot {self.robot}: {why.text}')
        if why and not why.cause.lasts and not decision.pause:
            if why.cause is not self._warned_of:
                self.warn(f'robot {self.robot}: {why.text}')
            self._warned_of, self._warned_at = why.cause, now
        elif now - self._warned_at > _OVER_AFTER_S:
            self._warned_of = None


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
        self._may_roll = False  # it has not stood since it was to move; else it is carried

    def judge(self, wheels: Velocities | None, sent: Velocities, now: float) -> str:
        """Return how the robot disobeys, empty if it obeys; cut the motors if it ignores zero.

        `wheels` is what its odometry has measured since the last call, None if nothing, and `sent`
        the last command: V in m/s, omega in rad/s. Now is in s.
        """
        if wheels:
            self._obedience.measure(*wheels, now)
        found = self._obedience.update(*sent, now)
        if found is Disobedience.IGNORES_ZERO or self._guard.found_deaf:
            self._cut_motors()
            # A robot that has come to rest has obeyed: a person pushes it.
            self.runs_away |= not self._obedience.came_to_rest
        elif self._guard.has_ended:  # its base keeps its last velocity
            self._motors.cut()
        self._motors.step(now)
        return found.value if found else self._disobeys

    def switch(self, decision: Decision, view: RobotView, now: float) -> None:
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


def _seen(view: RobotView, odom: Odometry, now: float) -> RobotView:
    """Return what is known of a robot after a pose of motion capture has come."""
    state = state_of(odom)
    if isinstance(state, str):
        return view
    age = max(0.0, time.time() - messages.seconds_of(odom.header.stamp))
    return replace(
        view,
        pose=state.pose,
        measured=now - age,
        received=now,
        same_since=view.same_since if state.pose == view.pose else now,
        velocities=velocities(odom.twist.twist),
    )


def _height(state: DiagnosticStatus) -> float:
    """Return the height of a body in m, NaN if it is unknown: any node may send such a state."""
    try:
        return float(diagnostic_values(state).get('height', ''))
    except ValueError:
        return math.nan


def robot_commands(node: FleetNode, robot: LabRobot) -> CmdVelPublisher:
    """Return a publisher of commands to a real robot."""
    cmd_vel, odom = robot.topic(topics.CMD_VEL), robot.topic(topics.ODOM)
    return CmdVelPublisher(node, robot.number, cmd_vel, odom, profile=qos.ROBOT_COMMAND)
