"""Markers of ROS topics as shapes in the plane: added, replaced, deleted, expired."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_tools.page.looks import colour_code

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
Key = tuple[str, str, int]
Change = tuple[str, Shape | None]

_KINDS = {SPHERE: 'discs', CYLINDER: 'discs', SPHERE_LIST: 'discs', ARROW: 'arrows', TEXT: 'texts'}
_SIZED = (ARROW, CUBE, SPHERE, CYLINDER, CUBE_LIST, SPHERE_LIST, POINTS, TEXT)
_MOST_POINTS = 5000  # of one marker
_LONGEST_TEXT = 200
_FARTHEST_M = 1e6
_LEAST_M, _FALLBACK_M = 0.01, 0.15


def planar_shape(marker: Any) -> Shape | None:
    """Return what a marker looks like from above; None if it has no finite place.

    Args:
        marker: A visualization_msgs/Marker; unknown types are shown as a square.
    """
    pose, scale = marker.pose, marker.scale
    q = pose.orientation
    yaw = yaw_of_quaternion(q.x, q.y, q.z, q.w)
    origin = np.array([pose.position.x, pose.position.y])
    points = np.array([(p.x, p.y) for p in marker.points[:_MOST_POINTS]]).reshape(-1, 2)
    size = [scale.x, scale.y]
    if not np.isfinite([yaw, *origin, *points.flat, *size]).all():
        return None
    cos, sin = math.cos(yaw), math.sin(yaw)
    turned = origin + points @ np.array([[cos, sin], [-sin, cos]])
    kind = _KINDS.get(marker.type, 'boxes')
    if marker.type in (LINE_STRIP, LINE_LIST):
        kind, places = 'lines', _segments(turned, marker.type == LINE_STRIP)
    elif marker.type == ARROW and len(points) >= 2:
        along = turned[1] - turned[0]
        size = [float(np.hypot(*along)), scale.y]
        places = np.array([[*turned[0], math.atan2(along[1], along[0])]])
    elif marker.type in (CUBE_LIST, SPHERE_LIST, POINTS):
        places = np.column_stack([turned, np.full(len(turned), yaw)])
    else:
        places = np.array([[*origin, yaw]])
    if marker.type not in _SIZED and kind != 'lines':
        size = [_FALLBACK_M, _FALLBACK_M]
    if not len(places):
        return None
    found = {
        'kind': kind,
        'robot': topics.robot_of(f'/{marker.header.frame_id.strip("/")}/') or 0,
        'places': np.clip(places, -_FARTHEST_M, _FARTHEST_M).round(4).tolist(),
        'size': [round(min(max(abs(one), _LEAST_M), _FARTHEST_M), 4) for one in size],
        **_colours(marker, len(places)),
    }
    return found | ({'text': marker.text[:_LONGEST_TEXT]} if kind == 'texts' else {})


def _segments(points: Floats, strip: bool) -> Floats:
    """Return segments as x, y of both ends, shape (n, 4)."""
    if strip:
        return np.column_stack([points[:-1], points[1:]])
    pairs = len(points) // 2 * 2
    return np.column_stack([points[:pairs:2], points[1:pairs:2]])


def _colours(marker: Any, count: int) -> Shape:
    """Return one colour, or one for each place."""
    own = marker.colors[:count] if len(marker.colors) == len(marker.points) else ()
    if marker.type == LINE_LIST:
        own = marker.colors[: 2 * count : 2]
    found = [*own] or [marker.color]
    return {
        'colours': [
            colour_code([_share(part) for part in (one.r, one.g, one.b)]) for one in found
        ],
        'alpha': round(_share(found[0].a), 3),
    }


def _share(part: float) -> float:
    return min(max(part, 0.0), 1.0) if math.isfinite(part) else 0.0


class MarkerStore:
    """Shapes by topic, namespace and id, and the changes since they were last taken."""

    def __init__(self) -> None:
        """Start without markers."""
        self._shapes: dict[Key, Shape] = {}
        self._ends: dict[Key, float] = {}
        self._changes: dict[Key, Shape | None] = {}

    def __len__(self) -> int:
        """Return the number of markers."""
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
        elif found != self._shapes.get(key):
            self._shapes.pop(key, None)  # to the end of the order
            self._shapes[key] = self._changes[key] = found
            if len(self._shapes) > MOST_MARKERS:
                self._drop([next(iter(self._shapes))])

    def expire(self, now: float) -> None:
        """Drop the markers whose lifetime is over."""
        self._drop([key for key, end in self._ends.items() if end <= now])

    def drop_topics(self, gone: Collection[str]) -> None:
        """Drop the markers of some topics."""
        self._drop([key for key in self._shapes if key[0] in gone])

    def take_changes(self) -> list[Change]:
        """Return the changed shapes since the last call by a name; None for one that is gone."""
        changes, self._changes = self._changes, {}
        return [('\0'.join(map(str, key)), found) for key, found in changes.items()]

    def _drop(self, keys: Sequence[Key]) -> None:
        for key in keys:
            self._ends.pop(key, None)
            if self._shapes.pop(key, None):
                self._changes[key] = None
