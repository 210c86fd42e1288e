"""Bridges of one robot: motion capture in, checked odometry out; commands in, checked ones out."""

from __future__ import annotations

import math
import time

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import BatteryState

from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.guard.obedience import IGNORES_ZERO, SLOWS_WITHIN_OVER_RADIO_S, Obedience
from setcmas_expe.lab.lab import Battery, Lab, LabRobot
from setcmas_expe.mocap.on_board import DeadReckoning
from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.mocap.sample import Sample, VelocityFilter
from setcmas_expe.safety.bridge_decision import Decision, State
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.ros import cmd_vel_topics, messages, qos
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher, OnlySender, velocities
from setcmas_simu.ros.polling import PolledTopic

_RECENT_S = 0.5


def robot_commands(node: Node, robot: LabRobot, lab: Lab) -> CmdVelPublisher:
    """Return a publisher of commands to a real robot."""
    return CmdVelPublisher(
        node,
        robot.number,
        robot.topic(topics.CMD_VEL),
        robot.topic(topics.ODOM),
        lab.cmd_vel_type,
        qos.ROBOT_COMMAND,
    )


class MocapBridge:
    """Publishes the poses of motion capture that pass its checks.

    Attributes:
        robot: Number of the robot.
        body: Name of its rigid body.
        track: Its poses, and which of them to believe.
        speed: Last estimate of its forward speed in m/s.
        turn_rate: Last estimate of its turn rate in rad/s.
        reckoning: Places poses that count from the start; None if they do not.
    """

    def __init__(self, node: Node, robot: LabRobot, lab: Lab) -> None:
        self.robot = robot.number
        self.body = robot.mocap_name
        self.track = PoseTrack(lab.arena, lab.limits)
        self.speed = self.turn_rate = 0.0
        start = robot.start if lab.mocap.source.from_start else None
        self.reckoning = DeadReckoning(start) if start else None
        self._filter = VelocityFilter()
        self._odometry = Odometry(child_frame_id=topics.robot_frame(robot.number))
        self._odometry.header.frame_id = topics.WORLD_FRAME
        self._publisher = node.create_publisher(
            Odometry, topics.mocap_topic(robot.number), qos.STATE
        )

    def take(self, sample: Sample) -> None:
        """Judge a measurement (Z-up), and publish it if it is good."""
        now = time.monotonic()
        if self.reckoning:
            sample = self.reckoning.placed(sample, now)
        if not self.track.take(sample, now):
            return
        self.speed, self.turn_rate = self._filter.update(sample, now)
        x, y, theta = sample.planar()
        out = self._odometry
        # Stamped by this machine's clock, so that a recording has one time.
        out.header.stamp = messages.stamp()
        out.pose.pose.position.x, out.pose.pose.position.y = x, y
        out.pose.pose.orientation.z, out.pose.pose.orientation.w = quaternion_of_yaw(theta)
        out.twist.twist.linear.x, out.twist.twist.angular.z = self.speed, self.turn_rate
        self._publisher.publish(out)

    @property
    def trouble(self) -> str:
        """Why its poses cannot be used, for messages; empty if they can."""
        return self.track.trouble or (self.reckoning.trouble if self.reckoning else '')


class CmdVelBridge:
    """Takes the commands of a controller, and sends the decisions of SafetyStepper.

    Attributes:
        robot: Number of the robot.
        topic: Full name of the topic that the robot listens to.
        cmd_vel: Publishes to the robot.
        V: Wanted forward speed in m/s.
        omega: Wanted turn rate in rad/s.
        rival: Another process that may move the robot or play it; empty if none.
        fault: Why the robot is not reliable: guard, wheels; empty if it is.
        robot_listens: Whether the robot listens to its commands.
        ignores_zero: Whether it moved although commanded zero, since the last pause.
        guard: The watch over its guard.
        wheels: Forward speed by its odometry in m/s, and time of arrival in s; None before.
        has_invalid_wheels: Whether its odometry had velocities that are NaN or infinite.
        battery: Charge in percent; None if unknown.
    """

    def __init__(self, node: Node, robot: LabRobot, lab: Lab, own: bytes) -> None:
        self.robot = robot.number
        self._node = node
        self.topic = robot.topic(topics.CMD_VEL)
        self.V = self.omega = 0.0
        self.rival = self.fault = ''
        self.robot_listens = True
        self.ignores_zero = self._was_paused = False
        self.guard = GuardWatch(node, robot.namespace)
        self._motors = MotorPower(node, robot.topic(topics.MOTOR_POWER))
        self.wheels: tuple[float, float] | None = None
        self.has_invalid_wheels = False
        self.battery: float | None = None
        self._scale = Battery()
        self._received = self._oldest = -math.inf
        self._obedience = Obedience(lab.limits, SLOWS_WITHIN_OVER_RADIO_S)
        self._sent = self._rolls = (0.0, 0.0)
        self._own = own
        odometry, battery = robot.topic(topics.ODOM), robot.topic(topics.BATTERY)
        self._odometry = OnlySender(node, odometry)
        self._impostor = ''
        self._demands_guard, self._demands_lidar = lab.guarded, lab.lidar_stop
        self._wanted = topics.robot_topic(robot.number, topics.CMD_VEL_WANTED)
        self.cmd_vel = robot_commands(node, robot, lab)
        self._commands = PolledTopic(
            node, TwistStamped, self._wanted, self._on_wanted, qos.COMMAND
        )
        self._wheels = PolledTopic(node, Odometry, odometry, self._on_wheels, qos.SENSOR)
        node.create_subscription(BatteryState, battery, self._on_battery, qos.SENSOR)

    def take(self, last: float, now: float) -> None:
        """Take the controller's newest command and the robot's messages; times in s.

        A command counts as old as the last call: it came some time after it.
        """
        self._oldest, self._now = last, now
        self._commands.take()
        self._wheels.take()
        self.guard.take(now)
        disobeys = self._obedience.update(*self._sent, now)
        if disobeys == IGNORES_ZERO:
            self.cut_motors()
        elif self.guard.has_ended:  # its base keeps its last velocity
            self._motors.cut()
        self._motors.step(now)
        self.fault = (
            self.guard.trouble(self._demands_guard, self._demands_lidar)
            or (
                ''
                if self.robot_listens
                else self.cmd_vel.mixed or f'nothing listens to {self.topic}; is it switched on?'
            )
            or disobeys
            or (IGNORES_ZERO if self.ignores_zero else '')
        )

    def cut_motors(self) -> None:
        """Switch the motors off until the next start: the robot moves although commanded zero."""
        if not self._motors.is_cut:
            off = 'its motors are off until the next start'
            way = off if self._motors.can_switch else 'it has no motor_power: switch it off'
            self._node.get_logger().error(f'robot {self.robot} does not obey zero: {way}')
        self._motors.cut()
        self.ignores_zero = True

    def age(self, now: float) -> float:
        """Return the age of the controller's last command in s; inf before the first."""
        return now - self._received

    def rolls(self, now: float) -> tuple[float, float] | None:
        """Return V (m/s) and omega (rad/s) by its own odometry; None if that is old or forged."""
        is_new = self.wheels is not None and now - self.wheels[1] < _RECENT_S
        return self._rolls if is_new and not self._impostor else None

    def look_around(self) -> None:
        """Look for other processes that command the robot or send its messages."""
        self.robot_listens = self.cmd_vel.follow_listeners()
        # The pause node may command zero; several of them pause all robots.
        operator = cmd_vel_topics.participants(self._node, topics.PAUSED)
        guards = self.guard.look_around()
        # Without a demanded guard, any process could play the guard of a robot that has none.
        allowed = {self._own} | operator | (guards if self._demands_guard else set())
        controllers = self._node.count_publishers(self._wanted)
        several = f'{controllers} controllers command it' if controllers > 1 else ''
        poses = topics.mocap_topic(self.robot)
        posers = cmd_vel_topics.strangers(self._node, poses, {self._own})
        posed = f'{posers[0]} sends poses of it to its law' if posers else ''
        self._impostor = self._odometry.impostor()
        rival = self.guard.intruder or cmd_vel_topics.rival(self._node, self.topic, allowed)
        self.rival = rival or self._impostor or several or posed

    def send(self, decision: Decision) -> None:
        """Command the robot; a start without a guard switches its motors on, whoever cut them."""
        if decision.state is State.PAUSED:
            self.ignores_zero, self._was_paused = False, True
            self._motors.leave()
        elif not (decision.lasting or self.guard.has_ended):
            if self._motors.is_cut or (self._was_paused and not self.guard.is_there()):
                self._motors.give()
            self._was_paused = False
        self._sent = decision.V, decision.omega
        self.cmd_vel.publish(*self._sent)

    def _on_wanted(self, message: TwistStamped) -> None:
        self.V, self.omega = velocities(message)
        self._received = self._oldest

    def _on_wheels(self, message: Odometry) -> None:
        V, omega = message.twist.twist.linear.x, message.twist.twist.angular.z
        if math.isfinite(V) and math.isfinite(omega):
            self._rolls = V, omega
            self.wheels = V, self._now
            self._obedience.measure(*self._rolls, self._now)
        else:
            self.has_invalid_wheels = True

    def _on_battery(self, message: BatteryState) -> None:
        self.battery = self._scale.percent(message.percentage)
