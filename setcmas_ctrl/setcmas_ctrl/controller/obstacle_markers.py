"""Markers of obstacles, and of the arena of a simulation: /obstacles."""

from __future__ import annotations

from collections.abc import Sequence

from geometry_msgs.msg import Point
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.world.arena import Arena
from setcmas_simu.world.obstacles import Obstacles

_LINE_M = 0.04
_HEIGHT_M = 0.2


def publish_obstacles(node: Node, obstacles: Obstacles, arena: Arena | None) -> None:
    """Publish what robots are kept off, if there is anything, kept for late displays."""
    markers = [_disc(*disc) for disc in obstacles.discs]
    markers += [_outline(polygon.corners) for polygon in obstacles.polygons]
    if arena:
        xmin, xmax, ymin, ymax = arena
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
