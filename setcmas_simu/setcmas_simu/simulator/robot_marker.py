"""Marker of a robot for RViz, in its colour: cubes for a unicycle, the parts of other robots."""

from __future__ import annotations

from collections.abc import Iterator

from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker

from setcmas_simu.fleet.fleet import colour
from setcmas_simu.fleet.topics import WORLD_FRAME, robot_name
from setcmas_simu.robots.shape import Prism, Shape, rectangle
from setcmas_simu.robots.unicycle import BURGER_SHAPE

_EDGE = 0.09  # m: two by two cubes are about as wide and high as a Burger
_BODY = [(0.0, side * _EDGE / 2, _EDGE * level) for side in (-1, 1) for level in (0.5, 1.5)]
_NOSE = (0.07, 0.0, 0.5 * _EDGE)  # shows the heading

_Corner = tuple[float, float, float]


def robot_marker(robot: int, frame_id: str = WORLD_FRAME, shape: Shape = BURGER_SHAPE) -> Marker:
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
    """Yield the corners in m of the triangles of a robot's parts, three per triangle."""
    for part in shape.prisms:
        yield from _sides(part)
    for wheel in shape.wheels:
        x, y = wheel.radius, 0.5 * wheel.width
        sides = rectangle((wheel.x - x, wheel.x + x), (wheel.y - y, wheel.y + y))
        yield from _sides(Prism(sides, 0.0, 2.0 * wheel.radius))


def _sides(prism: Prism) -> Iterator[_Corner]:
    """Yield the triangles of the top and the walls; the bottom is never seen."""
    high = [(x, y, prism.top) for x, y in prism.outline]
    low = [(x, y, prism.bottom) for x, y in prism.outline]
    for i in range(1, len(high) - 1):
        yield from (high[0], high[i], high[i + 1])
    for i, corner in enumerate(high):
        before = i - 1
        yield from (low[before], low[i], corner)
        yield from (low[before], corner, high[before])
