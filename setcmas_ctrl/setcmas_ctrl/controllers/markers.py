"""Markers that show a run: drawings of scripts, obstacles, the arena."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Sequence

from geometry_msgs.msg import Point
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.laws.drawing import Sphere
from setcmas_simu.fleet import topics
from setcmas_simu.robots.arena import Obstacles
from setcmas_simu.ros import qos
from setcmas_simu.ros.clocks import SteadyClock

TRAIL_LENGTH = 500
"""Number of spheres in a trail."""

_TRAIL = QoSProfile(depth=TRAIL_LENGTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class MarkerCanvas:
    """Publishes each drawing on /tb3_i/<name>, latched for displays that start later.

    Attributes:
        clock: That of the stamps; a law may draw when it is loaded, before there are robots.
    """

    def __init__(self, node: Node) -> None:
        self.clock = SteadyClock()
        self._node = node
        self._publishers: dict[tuple[int, str, type], Publisher] = {}
        # A trail consists of messages of one sphere each, so messages do not grow. Their ids
        # repeat, so that RViz replaces the oldest sphere.
        self._ids: defaultdict[tuple[int, str], itertools.cycle[int]] = defaultdict(
            lambda: itertools.cycle(range(TRAIL_LENGTH))
        )

    def show(self, robot: int, name: str, sphere: Sphere) -> None:
        """Show a sphere in place of the previous one of this robot and name."""
        self._publisher(robot, name, Marker).publish(self._marker(robot, name, sphere, 0))

    def extend_trail(self, robot: int, name: str, sphere: Sphere) -> None:
        """Add a sphere to the trail of this robot and name."""
        marker = self._marker(robot, name, sphere, next(self._ids[robot, name]))
        self._publisher(robot, name, MarkerArray).publish(MarkerArray(markers=[marker]))

    def _publisher(self, robot: int, name: str, kind: type) -> Publisher:
        key = (robot, name, kind)
        if key not in self._publishers:
            other = Marker if kind is MarkerArray else MarkerArray
            # A topic has one type; a script may use the same name for a marker and a trail.
            suffix = (
                f'_{kind.__name__.lower()}' if (robot, name, other) in self._publishers else ''
            )
            self._publishers[key] = self._node.create_publisher(
                kind,
                topics.robot_topic(robot, name + suffix),
                _TRAIL if kind is MarkerArray else qos.LATCHED,
            )
        return self._publishers[key]

    def _marker(self, robot: int, name: str, sphere: Sphere, number: int) -> Marker:
        marker = Marker(ns=f'{topics.robot_name(robot)}/{name}', id=number)
        marker.header.frame_id = topics.WORLD_FRAME
        marker.header.stamp = self.clock.stamp()
        marker.type, marker.action = Marker.SPHERE, Marker.ADD
        position = marker.pose.position
        position.x, position.y, position.z = sphere.x, sphere.y, sphere.z
        marker.scale.x = marker.scale.y = marker.scale.z = sphere.diameter
        marker.color.r, marker.color.g, marker.color.b = sphere.colour
        marker.color.a = sphere.alpha
        return marker


_LINE_M = 0.04
_HEIGHT_M = 0.2


def publish_obstacles(node: Node, safety: FilterOptions, in_experiment: bool) -> None:
    """Publish obstacles and arena, if there are any, latched for late displays.

    The arena of an experiment is the bridge's to show.
    """
    obstacles = Obstacles.of(safety.obstacles or '')
    markers = [_disc(*disc) for disc in obstacles.discs]
    markers += [_outline(polygon.corners) for polygon in obstacles.polygons]
    if safety.arena and not in_experiment:
        xmin, xmax, ymin, ymax = safety.arena
        markers.append(_outline([(xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax)]))
    for number, marker in enumerate(markers):
        marker.id = number
    if markers:
        publisher = node.create_publisher(MarkerArray, topics.OBSTACLES, qos.LATCHED)
        publisher.publish(MarkerArray(markers=markers))


def _disc(x: float, y: float, radius: float) -> Marker:
    marker = _marker(Marker.CYLINDER)
    marker.pose.position.x, marker.pose.position.y = x, y
    marker.pose.position.z = 0.5 * _HEIGHT_M
    marker.scale.x = marker.scale.y = 2.0 * radius
    marker.scale.z = _HEIGHT_M
    return marker


def _outline(corners: Sequence[tuple[float, float]]) -> Marker:
    marker = _marker(Marker.LINE_STRIP)
    marker.scale.x = _LINE_M
    marker.points = [Point(x=x, y=y, z=0.5 * _LINE_M) for x, y in (*corners, corners[0])]
    return marker


def _marker(kind: int) -> Marker:
    marker = Marker(ns='obstacles', type=kind, action=Marker.ADD)
    marker.header.frame_id = topics.WORLD_FRAME
    marker.pose.orientation.w = 1.0
    marker.color.r = marker.color.g = marker.color.b = 0.5
    marker.color.a = 1.0
    return marker
