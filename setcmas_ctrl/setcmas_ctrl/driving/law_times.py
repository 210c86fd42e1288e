"""When laws are called, and with poses of which age, for the latency of an experiment."""

from __future__ import annotations

from collections.abc import Iterable

from builtin_interfaces.msg import Time
from rclpy.node import Node
from sensor_msgs.msg import TimeReference

from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet.topics import LAW_TIME, robot_topic
from setcmas_simu.ros import qos

_NANOSECONDS = 10**9


class LawTimes:
    """Publishes when the laws are called (`header.stamp`), and the stamp of each robot's pose."""

    def __init__(self, node: Node, robots: Iterable[int]) -> None:
        self._publishers = {
            robot: node.create_publisher(TimeReference, robot_topic(robot, LAW_TIME), qos.EVENT)
            for robot in robots
        }

    def publish(self, called: Time, odometry: FleetOdometry) -> None:
        """Publish when the laws were called with the newest poses."""
        for robot, publisher in self._publishers.items():
            sec, nanosec = divmod(max(0, int(odometry.stamps[robot - 1])), _NANOSECONDS)
            message = TimeReference(time_ref=Time(sec=sec, nanosec=nanosec))
            message.header.stamp = called
            publisher.publish(message)
