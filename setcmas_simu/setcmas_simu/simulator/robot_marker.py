"""The picture of a robot for RViz: cubes in its colour that form a small TurtleBot3."""

from __future__ import annotations

from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker

from setcmas_simu.fleet.fleet import colour
from setcmas_simu.fleet.topics import WORLD_FRAME, robot_name

_EDGE = 0.09  # m: two by two cubes are about as wide and high as a Burger
_BODY = [(0.0, side * _EDGE / 2, _EDGE * level) for side in (-1, 1) for level in (0.5, 1.5)]
_NOSE = (0.07, 0.0, 0.5 * _EDGE)  # shows the heading


def robot_marker(robot: int, frame_id: str = WORLD_FRAME) -> Marker:
    """Return the marker of a robot; its stamp and pose are to be filled in."""
    red, green, blue = colour(robot)
    marker = Marker(ns=robot_name(robot), id=robot, type=Marker.CUBE_LIST, action=Marker.ADD)
    marker.header.frame_id = frame_id
    marker.scale.x = marker.scale.y = marker.scale.z = _EDGE
    marker.color.r, marker.color.g, marker.color.b, marker.color.a = red, green, blue, 1.0
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in [*_BODY, _NOSE]]
    return marker
