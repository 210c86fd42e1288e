"""Draws the spheres of control scripts as RViz markers."""

from __future__ import annotations

import itertools
from collections import defaultdict

from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_ctrl.drawing import Sphere
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos, ros_time

TRAIL_LENGTH = 500
"""Number of spheres that a trail keeps."""

_TRAIL = QoSProfile(depth=TRAIL_LENGTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class MarkerCanvas:
    """Publishes each drawing on /tb3_i/<name>, so that displays that come late see it too.

    Attributes:
        profile: Quality of service of markers.
    """

    def __init__(self, node: Node) -> None:
        """Draw through a node."""
        self.profile = qos.LATCHED
        self._node = node
        self._publishers: dict[tuple[int, str, type], Publisher] = {}
        # A trail is many messages of one sphere each, which do not grow; ids go round, so that
        # in RViz a new sphere takes the place of the oldest.
        self._ids: defaultdict[tuple[int, str], itertools.cycle[int]] = defaultdict(
            lambda: itertools.cycle(range(TRAIL_LENGTH))
        )

    def show(self, robot: int, name: str, sphere: Sphere) -> None:
        """Show a sphere in place of the last one of this robot and name."""
        self._publisher(robot, name, Marker).publish(self._marker(robot, name, sphere, 0))

    def extend_trail(self, robot: int, name: str, sphere: Sphere) -> None:
        """Add a sphere to the trail of this robot and name."""
        marker = self._marker(robot, name, sphere, next(self._ids[robot, name]))
        self._publisher(robot, name, MarkerArray).publish(MarkerArray(markers=[marker]))

    def _publisher(self, robot: int, name: str, kind: type) -> Publisher:
        key = (robot, name, kind)
        if key not in self._publishers:
            other = Marker if kind is MarkerArray else MarkerArray
            # A topic has one type; scripts may use one name for a marker and for a trail.
            suffix = (
                f'_{kind.__name__.lower()}' if (robot, name, other) in self._publishers else ''
            )
            self._publishers[key] = self._node.create_publisher(
                kind,
                topics.robot_topic(robot, name + suffix),
                _TRAIL if kind is MarkerArray else self.profile,
            )
        return self._publishers[key]

    def _marker(self, robot: int, name: str, sphere: Sphere, number: int) -> Marker:
        marker = Marker(ns=f'{topics.robot_name(robot)}/{name}', id=number)
        marker.header.frame_id = topics.WORLD_FRAME
        marker.header.stamp = ros_time.stamp()
        marker.type, marker.action = Marker.SPHERE, Marker.ADD
        marker.lifetime = Duration()  # for ever
        position = marker.pose.position
        position.x, position.y, position.z = map(float, (sphere.x, sphere.y, sphere.z))
        marker.scale.x = marker.scale.y = marker.scale.z = float(sphere.diameter)
        marker.color.r, marker.color.g, marker.color.b = map(float, sphere.colour[:3])
        marker.color.a = float(sphere.alpha)
        return marker
