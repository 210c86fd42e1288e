"""Bridges of one robot: motion capture in, checked odometry out; commands in, checked ones out."""

from __future__ import annotations

import math
import time

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState

from setcmas_expe.guard.guard_watch import GuardWatch
from setcmas_expe.guard.motor_power import MotorPower
from setcmas_expe.lab.lab import Battery, Lab, LabRobot
from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.velocity_filter import VelocityFilter
from setcmas_expe.safety.obedience import Obedience
from setcmas_expe.safety.safety_decision import Decision
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.ros import cmd_vel_topics, messages, qos
from setcmas_simu.ros.cmd_vel_topics import CmdVelPublisher, OnlySender, velocities
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.ros.process import FleetNode


class MocapBridge(FleetNode):
    """Lets only poses through that can be believed.

    Attributes:
        robot: Number of the robot.
        body: Name of its rigid body.
        track: What is known of its pose.
        speed: Its forward speed in m/s, as estimated last.
        turn_rate: Its turn rate in rad/s, likewise.
    """

    def __init__(self, robot: LabRobot, lab: Lab) -> None:
        """Create the node in the robot's namespace."""
        super().__init__('mocap_bridge', namespace=topics.robot_name(robot.number))
        self.robot = robot.number
        self.body = robot.mocap_name
        self.track = PoseTrack(lab.arena, lab.limits)
        self.speed = self.turn_rate = 0.0
        self._filter = VelocityFilter()
        self._odometry = Odometry(child_frame_id=topics.robot_frame(robot.number))
        self._odometry.header.frame_id = topics.WORLD_FRAME
        self._publisher = self.create_publisher(
            Odometry,
            topics.mocap_topic(robot.number),
            qos.STATE,
        )

    def take(self, sample: Sample) -> None:
        """Judge a measurement (Z-up), and pass it on if it is good."""
        now = time.monotonic()
        if not self.track.take(sample, now):
            return
        self.speed, self.turn_rate = self._filter.update(sample, now)
        x, y, theta = sample.planar()
        out = self._odometry
        # Our own clock: all that is recorded here is to have one time.
        out.header.stamp = self.get_clock().now().to_msg()
        out.pose.pose.position.x, out.pose.pose.position.y = x, y
        out.pose.pose.orientation.z, out.pose.pose.orientation.w = quaternion_of_yaw(theta)
        out.twist.twist.linear.x, out.twist.twist.angular.z = self.speed, self.turn_rate
        self._publisher.publish(out)


_RECENT_S = 0.5


class CmdVelBridge(FleetNode):
    """Keeps what a controller wants, and sends what was decided; SafetyStepper decides.

    Attributes:
        robot: Number of the robot.
        topic: Full name of the topic that the robot listens to.
        cmd_vel: Publishes to the robot.
        V: Forward speed that is wanted, in m/s.
        omega: Turn rate that is wanted, in rad/s.
        rival: Who else may move the robot, or move in its place; empty if nobody.
        fault: Why the robot cannot be relied upon: guard, wheels; empty if it can.
        is_heard: Whether something listens to its commands.
        guard: What is known of its guard.
        wheels: Forward speed by its own odometry in m/s, and when that came in s; None before.
        battery: Charge in percent; None if the robot does not tell.
    """

    def __init__(self, robot: LabRobot, lab: Lab) -> None:
        """Create the node in the robot's namespace."""
        super().__init__(topics.CMD_VEL_BRIDGE_NODE, namespace=topics.robot_name(robot.number))
        self.robot = robot.number
        self.topic = robot.topic(topics.CMD_VEL)
        self.V = self.omega = 0.0
        self.rival = self.fault = ''
        self.is_heard = True
        self.guard = GuardWatch(self, robot.namespace)
        self._motors = MotorPower(self, robot.topic(topics.MOTOR_POWER))
        self.wheels: tuple[float, float] | None = None
        self.battery: float | None = None
        self._scale = Battery()
        self._received = self._comes_from = -math.inf
        self._obedience = Obedience(lab.limits)
        self._sent = self._rolls = (0.0, 0.0)
        self._own = cmd_vel_topics.own_participant(self)
        self._odometry = OnlySender(self, robot.topic(topics.ODOM))
        self._impostor = ''
        self._demands_guard = lab.guarded
        self._wanted = topics.robot_topic(robot.number, topics.CMD_VEL_WANTED)
        self.cmd_vel = CmdVelPublisher(
            self,
            robot.number,
            self.topic,
            robot.topic(topics.ODOM),
            lab.cmd_vel_type,
            qos.ROBOT_COMMAND,
        )
        self._commands = PolledTopic(
            self, TwistStamped, self._wanted, self._on_wanted, qos.COMMAND
        )
        self._wheels = PolledTopic(
            self,
            Odometry,
            robot.topic(topics.ODOM),
            self._on_wheels,
            qos.SENSOR,
            encoded=True,
        )
        self.create_subscription(
            BatteryState, robot.topic(topics.BATTERY), self._on_battery, qos.SENSOR
        )

    def take(self, last: float, now: float) -> None:
        """Take the newest command of the controller, and what the robot says.

        Args:
            last: When commands were taken last, in s: it counts as old as it can be.
            now: The time in s.
        """
        self._comes_from, self._now = last, now
        self._commands.take()
        self._wheels.take()
        self.guard.take(now)
        if self.guard.has_ended:  # its base goes on by the last command
            self._motors.cut()
        else:
            self._motors.leave()
        self._motors.step(now)
        self.fault = (
            self.guard.trouble(self._demands_guard)
            or ('' if self.is_heard else f'nothing listens to {self.topic}; is it switched on?')
            or self._obedience.update(*self._sent, now)
        )

    def age(self, now: float) -> float:
        """Return how old the last command of the controller is, in s; inf before the first."""
        return now - self._received

    def rolls(self, now: float) -> tuple[float, float] | None:
        """Return V (m/s) and omega (rad/s) by its own odometry; None if that does not tell."""
        return self._rolls if self.tells_wheels(now) else None

    def tells_wheels(self, now: float) -> bool:
        """Return whether its own odometry is there, and its alone."""
        is_new = self.wheels is not None and now - self.wheels[1] < _RECENT_S
        return is_new and not self._impostor

    def look_around(self) -> None:
        """See who else commands the robot, or is taken for it."""
        self.is_heard = self.cmd_vel.follow_listeners()
        # The pause node may command zero; several of them pause all robots.
        operator = cmd_vel_topics.participants(self, topics.PAUSED)
        guards = self.guard.look_around()
        # Where none is demanded anybody could play the guard of a robot that has none.
        allowed = {self._own} | operator | (guards if self._demands_guard else set())
        controllers = self.count_publishers(self._wanted)
        several = f'{controllers} controllers want to move it' if controllers > 1 else ''
        seen_by = cmd_vel_topics.strangers(self, topics.mocap_topic(self.robot), {self._own})
        posed = f'{seen_by[0]} sends poses of it to its law' if seen_by else ''
        self._impostor = self._odometry.impostor()
        rival = self.guard.intruder or cmd_vel_topics.rival(self, self.topic, allowed)
        self.rival = rival or self._impostor or several or posed

    def send(self, decision: Decision) -> None:
        """Command the robot."""
        self._sent = decision.V, decision.omega
        self.cmd_vel.publish(*self._sent)

    def _on_wanted(self, message: TwistStamped) -> None:
        self.V, self.omega = velocities(message)
        self._received = self._comes_from

    def _on_wheels(self, message: bytes) -> None:
        told = messages.read_odometry(message)
        self.wheels, self._rolls = (told.V, self._now), (told.V, told.omega)
        self._obedience.hear(*self._rolls, self._now)

    def _on_battery(self, message: BatteryState) -> None:
        self.battery = self._scale.percent(message.percentage)
