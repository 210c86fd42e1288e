"""ROS interface of an emulated TurtleBot3: topics and node name of the real one."""

from __future__ import annotations

import math
from collections.abc import Callable

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from sensor_msgs.msg import BatteryState, LaserScan
from std_srvs.srv import SetBool

from setcmas_expe.emulation.emulated_fleet import LIDAR_POINTS
from setcmas_expe.lab.lab import LabRobot
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import Pose
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.cmd_vel_topics import velocities
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.polling import PolledTopic, RequestWait

NODE_NAME = 'turtlebot3_node'
_QOS = QoSProfile(depth=10)  # as turtlebot3_node: reliable, keep last 10


class EmulatedTurtleBot3(FleetNode):
    """Takes commands and sends wheel odometry and battery as a real robot does.

    `commands` are those to its base, `requests` those to its services.
    """

    def __init__(
        self,
        robot: LabRobot,
        cmd_vel: str,
        on_command: Callable[[float, float], None],
        on_torque: Callable[[bool], None],
    ) -> None:
        """Create the node in the robot's namespace, where its base listens to `cmd_vel`.

        `on_command` gets forward speed (m/s) and turn rate (rad/s), `on_torque` whether motors are
        on.
        """
        super().__init__(NODE_NAME, namespace=robot.namespace)
        self._on_torque = on_torque
        self._odom = Odometry(child_frame_id='base_footprint')
        self._odom.header.frame_id = 'odom'
        self._odom_publisher = self.create_publisher(Odometry, topics.ODOM, _QOS)
        step = 2.0 * math.pi / LIDAR_POINTS
        self._scan = LaserScan(angle_increment=step, range_min=0.12, range_max=3.5)
        self._scan.header.frame_id = 'base_scan'
        self._scan_publisher = self.create_publisher(LaserScan, topics.SCAN, qos.SENSOR)
        self._battery = BatteryState(present=True)
        self._battery_publisher = self.create_publisher(BatteryState, topics.BATTERY, _QOS)
        self.commands = PolledTopic(
            self, TwistStamped, cmd_vel, lambda sent: on_command(*velocities(sent)), _QOS
        )
        self.create_service(SetBool, topics.MOTOR_POWER, self._on_motor_power)
        self.requests = RequestWait([self])

    def publish_odometry(self, stamp: Time, pose: Pose, V: float, omega: float) -> None:
        """Publish the pose by the wheels (m, rad) and their speeds."""
        self._odom.header.stamp = stamp
        messages.fill_odometry(self._odom, pose, V, omega)
        self._odom_publisher.publish(self._odom)

    def publish_scan(self, stamp: Time, ranges: Floats) -> None:
        """Publish the distances (m) of a turn of its lidar."""
        self._scan.header.stamp = stamp
        self._scan.ranges = ranges.tolist()
        self._scan_publisher.publish(self._scan)

    def publish_battery(self, stamp: Time, percent: float) -> None:
        """Publish the charge, from 0 to 100 as the real robot does."""
        self._battery.header.stamp = stamp
        self._battery.percentage = percent
        self._battery_publisher.publish(self._battery)

    def _on_motor_power(
        self, request: SetBool.Request, response: SetBool.Response
    ) -> SetBool.Response:
        self._on_torque(request.data)
        response.success = True
        return response
