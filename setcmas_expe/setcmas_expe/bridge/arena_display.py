"""Display of a lab: the border of its arena, and how far apart robots must stay."""

from __future__ import annotations

from geometry_msgs.msg import Point
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_expe.lab.lab import Lab
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos

_LINE_M = 0.03
_DISC_M = 0.005


def publish_arena(node: Node, lab: Lab) -> None:
    """Publish the arena's border and a disc around each robot, kept for late displays."""
    publisher = node.create_publisher(MarkerArray, topics.ARENA, qos.LATCHED)
    robots = [_separation(robot.number, lab.min_separation) for robot in lab.robots]
    publisher.publish(MarkerArray(markers=[_border(lab), *robots]))


def _border(lab: Lab) -> Marker:
    xmin, xmax, ymin, ymax = lab.arena
    corners = [(xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax), (xmin, ymin)]
    marker = Marker(ns='arena', id=0, type=Marker.LINE_STRIP, action=Marker.ADD)
    marker.header.frame_id = topics.WORLD_FRAME
    marker.pose.orientation.w = 1.0
    marker.scale.x = _LINE_M
    marker.color.r, marker.color.a = 1.0, 1.0
    marker.points = [Point(x=x, y=y) for x, y in corners]
    return marker


def _separation(robot: int, diameter: float) -> Marker:
    # Robots are too close when their discs touch.
    marker = Marker(ns='separation', id=robot, type=Marker.CYLINDER, action=Marker.ADD)
    marker.header.frame_id = topics.robot_frame(robot)
    marker.frame_locked = True
    marker.pose.orientation.w = 1.0
    marker.scale.x = marker.scale.y = diameter
    marker.scale.z = _DISC_M
    marker.color.r, marker.color.g, marker.color.a = 1.0, 0.6, 0.4
    return marker
