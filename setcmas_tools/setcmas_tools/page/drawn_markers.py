"""Markers of ROS topics as shapes in the plane: added, replaced, deleted, expired."""

from __future__ import annotations

import functools
import math
from collections.abc import Collection, Sequence
from itertools import pairwise
from typing import Any

import msgspec

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_tools.page.page_data import colour_code

ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST = range(8)
POINTS, TEXT = 8, 9
"""Values of visualization_msgs/Marker.type."""
ADD, DELETE, DELETE_ALL = 0, 2, 3
"""Values of visualization_msgs/Marker.action."""
MOST_MARKERS = 30_000
"""Beyond, the oldest is dropped."""

Shape = dict[str, Any]
"""A shape as `plane.js` draws it: kind, robot in whose frame it is (0 for the world), places,
size in m, colours and alpha; and the text of a label.
"""
Point = tuple[float, float]
Key = tuple[str, str, int]
Change = tuple[str, msgspec.Raw | None]
"""Name of a shape, and the shape as JSON; None if it is gone."""

_KINDS = {SPHERE: 'discs', CYLINDER: 'discs', SPHERE_LIST: 'discs', ARROW: 'arrows', TEXT: 'texts'}
_OF_POINTS = (ARROW, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS)
_SIZED = (*_OF_POINTS, CUBE, SPHERE, CYLINDER, TEXT)
_MOST_POINTS = 5000  # of one marker
_LONGEST_TEXT = 200
_FARTHEST_M = 1e6
_LEAST_M, _FALLBACK_M = 0.01, 0.15


def planar_shape(marker: Any) -> Shape | None:
    """Return the shape of a marker from above; None if it has no finite place.

    Args:
        marker: A visualization_msgs/Marker; unknown types are shown as a square.
    """
    pose, size = marker.pose, (marker.scale.x, marker.scale.y)
    q = pose.orientation
    yaw = float(yaw_of_quaternion(q.x, q.y, q.z, q.w))
    origin, points = (pose.position.x, pose.position.y), marker.points[:_MOST_POINTS]
    numbers = [part for point in points for part in (point.x, point.y)]
    if not all(map(math.isfinite, (yaw, *origin, *size, *numbers))):
        return None
    kind = _KINDS.get(marker.type, 'boxes')
    places: list[tuple[float, ...]] = [(*origin, yaw)]
    if marker.type not in _SIZED:
        size = (_FALLBACK_M, _FALLBACK_M)
    if marker.type in _OF_POINTS and (len(points) > 1 or marker.type != ARROW):
        kind, places, size = _of_points(marker, _moved(origin, yaw, points), size, yaw)
    if not places:
        return None
    found = {
        'kind': kind,
        'robot': topics.robot_of(f'/{marker.header.frame_id.strip("/")}/') or 0,
        'places': [
            [round(min(max(part, -_FARTHEST_M), _FARTHEST_M), 4) for part in place]
            for place in places
        ],
        'size': [round(min(max(abs(side), _LEAST_M), _FARTHEST_M), 4) for side in size],
        **_colours(marker, len(places)),
    }
    return found | ({'text': marker.text[:_LONGEST_TEXT]} if kind == 'texts' else {})


def _moved(origin: Point, yaw: float, points: Sequence[Any]) -> list[Point]:
    """Return points of a marker's frame in the frame of its pose."""
    (x, y), cos, sin = origin, math.cos(yaw), math.sin(yaw)
    return [(x + p.x * cos - p.y * sin, y + p.x * sin + p.y * cos) for p in points]


def _of_points(
    marker: Any, points: Sequence[Point], size: Point, yaw: float
) -> tuple[str, list[tuple[float, ...]], Point]:
    """Return kind, places and size of a marker that consists of points."""
    if marker.type == LINE_STRIP:
        return 'lines', [(*a, *b) for a, b in pairwise(points)], size
    if marker.type == LINE_LIST:
        return 'lines', [(*a, *b) for a, b in zip(points[::2], points[1::2], strict=False)], size
    if marker.type == ARROW:
        (x, y), (tip_x, tip_y) = points[:2]
        along = tip_x - x, tip_y - y
        return 'arrows', [(x, y, math.atan2(*along[::-1]))], (math.hypot(*along), size[1])
    return _KINDS.get(marker.type, 'boxes'), [(*point, yaw) for point in points], size


def _colours(marker: Any, count: int) -> Shape:
    """Return one colour, or one for each place."""
    own = marker.colors[:count] if len(marker.colors) == len(marker.points) else ()
    if marker.type == LINE_LIST:
        own = marker.colors[: 2 * count : 2]
    found = [*own] or [marker.color]
    return {
        'colours': [_code(one.r, one.g, one.b) for one in found],
        'alpha': round(_share(found[0].a), 3),
    }


@functools.lru_cache(1000)
def _code(*parts: float) -> str:
    return colour_code([_share(part) for part in parts])


def _share(part: float) -> float:
    return min(max(part, 0.0), 1.0) if math.isfinite(part) else 0.0


class MarkerStore:
    """Shapes by topic, namespace and id, and the changes since they were last taken.

    They are kept as JSON: a trail of thousands then takes a fifth of the memory.
    """

    def __init__(self) -> None:
        self._shapes: dict[Key, bytes] = {}
        self._ends: dict[Key, float] = {}
        self._changes: dict[Key, bytes | None] = {}

    def __len__(self) -> int:
        return len(self._shapes)

    def apply(self, topic: str, marker: Any, now: float) -> None:
        """Add, replace or delete a marker.

        Args:
            topic: Where it came from.
            marker: A visualization_msgs/Marker.
            now: Time in s.
        """
        key = (topic, marker.ns, marker.id)
        if marker.action == DELETE_ALL:
            self._drop([k for k in self._shapes if k[0] == topic and marker.ns in ('', k[1])])
        elif marker.action == DELETE:
            self._drop([key])
        elif marker.action == ADD:
            self._put(key, planar_shape(marker))
            lifetime = marker.lifetime.sec + 1e-9 * marker.lifetime.nanosec
            if lifetime > 0:
                self._ends[key] = now + lifetime

    def _put(self, key: Key, found: Shape | None) -> None:
        self._ends.pop(key, None)
        if found is None:
            self._drop([key])
            return
        encoded = msgspec.json.encode(found)
        if encoded != self._shapes.get(key):
            self._shapes.pop(key, None)  # to the end of the order
            self._shapes[key] = self._changes[key] = encoded
            if len(self._shapes) > MOST_MARKERS:
                self._drop([next(iter(self._shapes))])

    def expire(self, now: float) -> None:
        """Drop the markers whose lifetime is over."""
        self._drop([key for key, end in self._ends.items() if end <= now])

    def drop_topics(self, gone: Collection[str]) -> None:
        """Drop the markers of some topics."""
        if gone:
            self._drop([key for key in self._shapes if key[0] in gone])

    def take_changes(self) -> list[Change]:
        """Return the changed shapes since the last call."""
        changes, self._changes = self._changes, {}
        return [
            ('\0'.join(map(str, key)), None if found is None else msgspec.Raw(found))
            for key, found in changes.items()
        ]

    def _drop(self, keys: Sequence[Key]) -> None:
        for key in keys:
            self._ends.pop(key, None)
            if self._shapes.pop(key, None):
                self._changes[key] = None
