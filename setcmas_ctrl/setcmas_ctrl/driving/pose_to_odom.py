"""Odometry from poses, for sources that publish PoseStamped, such as motion capture drivers.

Start: `ros2 run setcmas_ctrl pose_to_odom --robots 1-2 --pose-topic /vrpn_mocap/{name}/pose`.
"""

from __future__ import annotations

import argparse
import sys

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import parse_robots
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_simu.robots.unicycle import velocities_between
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import FleetNode, RosProcess, node_main

_SHORTEST_STEP_S = 1e-3
_LONGEST_STEP_S = 1.0


class PoseToOdom(FleetNode):
    """Publishes the poses of one robot as odometry, with velocities by backward differences."""

    def __init__(self, robot: int, pose_topic: str) -> None:
        """Create the node in the robot's namespace.

        Args:
            robot: Number of the robot.
            pose_topic: Topic of its poses; `{name}` is the robot's name.
        """
        super().__init__('pose_to_odom', namespace=topics.robot_name(robot))
        self._last: tuple[float, tuple[float, float, float]] | None = None
        self._publisher = self.create_publisher(Odometry, topics.ODOM, qos.STATE)
        self._message = Odometry(child_frame_id=topics.robot_frame(robot))
        self.create_subscription(
            PoseStamped,
            pose_topic.replace('{name}', topics.robot_name(robot)),
            self._on_pose,
            qos.SENSOR,
        )

    def _on_pose(self, message: PoseStamped) -> None:
        position, q = message.pose.position, message.pose.orientation
        pose = (position.x, position.y, yaw_of_quaternion(q.x, q.y, q.z, q.w))
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        self._message.header = message.header
        self._message.pose.pose = message.pose
        V, omega = self._velocities(stamp, pose)
        self._message.twist.twist.linear.x, self._message.twist.twist.angular.z = V, omega
        self._publisher.publish(self._message)
        self._last = (stamp, pose)

    def _velocities(self, stamp: float, pose: tuple[float, float, float]) -> tuple[float, float]:
        if self._last is None:
            return 0.0, 0.0
        step = stamp - self._last[0]
        # Repeated stamps and gaps give no useful difference.
        if not _SHORTEST_STEP_S <= step <= _LONGEST_STEP_S:
            return 0.0, 0.0
        V, omega = velocities_between(self._last[1], pose, step)
        return float(V), float(omega)


def main(argv: list[str] | None = None) -> int:
    """Republish until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='pose_to_odom', description=__doc__)
    parser.add_argument('--robots', default='1', metavar='LIST', help='such as 1-4 (default: 1)')
    parser.add_argument(
        '--pose-topic',
        default=f'/{{name}}/{topics.POSE}',
        metavar='TOPIC',
        help='topic of the poses; {name} is the robot (default: %(default)s)',
    )
    return node_main(parser, _republish, argv)


def _republish(process: RosProcess, args: argparse.Namespace) -> None:
    robots = parse_robots(args.robots)
    process.add(*[PoseToOdom(robot, args.pose_topic) for robot in robots])
    process.spin()


if __name__ == '__main__':
    sys.exit(main())
