"""Messages with the state of a robot: odometry, pose, marker and transform."""

from __future__ import annotations

from collections.abc import Iterator

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from visualization_msgs.msg import Marker

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.palettes import colour
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.model import Shape
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_simu.ros import qos

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # no wheel exists
    TFMessage = None


class StatePublisher:
    """Publishes the state of a robot; what only displays need, only for those found last."""

    def __init__(self, node: Node, robot: int, frame_id: str, child: str, shape: Shape) -> None:
        """Create the topics of a robot on its node: its frame `child` moves in `frame_id`."""
        self._odometry, self._pose = Odometry(child_frame_id=child), PoseStamped()
        self._odometry.header.frame_id = self._pose.header.frame_id = frame_id
        self._marker = robot_marker(robot, frame_id, shape)
        odom = node.create_publisher(Odometry, topics.ODOM, qos.STATE)
        self._own = odom, self._odometry, self._odometry.pose.pose
        self._displays = [
            (node.create_publisher(PoseStamped, topics.POSE, qos.STATE), self._pose),
            (node.create_publisher(Marker, topics.MARKER, qos.STATE), self._marker),
        ]
        self.find_displays()
        self._tf = None
        if TFMessage:
            self._tf = node.create_publisher(TFMessage, topics.TF, qos.EVENT)
            transform = TransformStamped(child_frame_id=child)
            transform.header.frame_id = frame_id
            self._transforms = TFMessage(transforms=[transform])

    def find_displays(self) -> None:
        """Find out who subscribes; to be called now and then, as it costs as much as a message."""
        self._wanted = [
            (publisher, message, message.pose)
            for publisher, message in self._displays
            if publisher.get_subscription_count()
        ]

    def publish(self, state: Floats, stamp: Time) -> None:
        """Publish x, y (m), theta (rad), and the velocities forward, left (m/s) and turn rate."""
        x, y, theta, V, left, omega = state.tolist()
        z, w = map(float, quaternion_of_yaw(theta))
        twist = self._odometry.twist.twist
        twist.linear.x, twist.linear.y, twist.angular.z = V, left, omega
        for publisher, message, pose in (self._own, *self._wanted):
            message.header.stamp = stamp
            pose.position.x, pose.position.y = x, y
            pose.orientation.z, pose.orientation.w = z, w
            publisher.publish(message)
        if self._tf:
            transform = self._transforms.transforms[0]
            transform.header.stamp = stamp
            transform.transform.translation.x, transform.transform.translation.y = x, y
            transform.transform.rotation.z, transform.transform.rotation.w = z, w
            self._tf.publish(self._transforms)


_EDGE = 0.09  # m: two by two cubes are about as wide and high as a Burger
_BODY = [(0.0, side * _EDGE / 2, _EDGE * level) for side in (-1, 1) for level in (0.5, 1.5)]
_NOSE = (0.07, 0.0, 0.5 * _EDGE)  # shows the heading

_Corner = tuple[float, float, float]


def robot_marker(robot: int, frame_id: str, shape: Shape) -> Marker:
    """Return the marker of a robot, still without stamp and pose."""
    red, green, blue = colour(robot)
    marker = Marker(ns=robot_name(robot), id=robot, action=Marker.ADD)
    marker.header.frame_id = frame_id
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = red, green, blue, 1.0
    if shape is BURGER_SHAPE:  # five cubes cost less than triangles, ten times a second
        marker.type, corners, size = Marker.CUBE_LIST, [*_BODY, _NOSE], _EDGE
    else:
        marker.type, corners, size = Marker.TRIANGLE_LIST, list(_triangles(shape)), 1.0
    marker.scale.x = marker.scale.y = marker.scale.z = size
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in corners]
    return marker


def _triangles(shape: Shape) -> Iterator[_Corner]:
    """Yield the corners in m of the triangles of a body's top and walls, three per triangle."""
    low = [(x, y, 0.0) for x, y in shape.body]
    high = [(x, y, shape.height) for x, y in shape.body]
    for i in range(1, len(high) - 1):
        yield from (high[0], high[i], high[i + 1])
    for i, corner in enumerate(high):
        before = i - 1
        yield from (low[before], low[i], corner)
        yield from (low[before], corner, high[before])
