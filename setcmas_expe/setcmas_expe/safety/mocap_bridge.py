"""Mocap bridge of one robot: poses of a motion capture driver in, checked odometry out."""

from __future__ import annotations

import time

from nav_msgs.msg import Odometry

from setcmas_expe.lab.model import Lab, LabRobot
from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.velocity_filter import VelocityFilter
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.ros import qos
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
