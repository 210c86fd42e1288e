"""Transforms world -> tb3_i, if ROS's transform messages are installed."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.fleet.topics import TF
from setcmas_simu.ros import qos

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # no wheel exists
    TFMessage = None


class FleetTransforms:
    """Publishes the transforms of all robots of a process in one message."""

    def __init__(self, node: Node, frames: list[tuple[str, str]]) -> None:
        """Prepare the message; log once if /tf cannot be published.

        Args:
            node: The node that publishes.
            frames: Parent and child frame of each robot.
        """
        self._publisher = None
        if TFMessage is None:
            node.get_logger().info('no /tf (tf2_msgs is not installed; nothing here needs it)')
            return
        self._message = TFMessage()
        for parent, child in frames:
            transform = TransformStamped(child_frame_id=child)
            transform.header.frame_id = parent
            self._message.transforms.append(transform)
        self._publisher = node.create_publisher(TFMessage, TF, qos.EVENT)

    def publish(self, stamp: Time, poses: Floats) -> None:
        """Publish the poses, shape (3, N), of the robots in the order of the frames."""
        if self._publisher is None:
            return
        for transform, (x, y, theta) in zip(
            self._message.transforms, poses.T.tolist(), strict=True
        ):
            transform.header.stamp = stamp
            transform.transform.translation.x, transform.transform.translation.y = x, y
            rotation = transform.transform.rotation
            rotation.z, rotation.w = quaternion_of_yaw(theta)
        self._publisher.publish(self._message)
