"""Drawings of control laws, obstacles and arenas on ROS topics, as shapes in the plane."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from itertools import pairwise
from typing import Any

import msgspec

from setcmas_simu.fleet import topics
from setcmas_tools.page.page_data import colour_code

SPHERE, CYLINDER, LINE_STRIP = 2, 3, 4
"""Values of visualization_msgs/Marker.type: what controllers and bridges publish."""
MOST_MARKERS = 30_000
"""Beyond, the oldest is dropped."""

Shape = dict[str, Any]
"""A shape as `plane.js` draws it: kind, robot in whose frame it is (0 for the world), places,
size in m, colour and alpha.
"""
Key = tuple[str, str, int]
Change = tuple[str, msgspec.Raw | None]
"""Name of a shape, and the shape as JSON; None if it is gone."""

_FARTHEST_M = 1e6
_LEAST_M = 0.01


def planar_shape(marker: Any) -> Shape | None:
    """Return a disc or a line from above for a visualization_msgs/Marker, which is not turned.

    None for other markers, or without a finite place.
    """
    x, y, size = marker.pose.position.x, marker.pose.position.y, marker.scale.x
    places: list[tuple[float, ...]] = [(x, y)]
    if marker.type == LINE_STRIP:
        places = [(a.x, a.y, b.x, b.y) for a, b in pairwise(marker.points)]
    elif marker.type not in (SPHERE, CYLINDER):
        return None
    colour = marker.color.r, marker.color.g, marker.color.b, marker.color.a
    if not places or not all(map(math.isfinite, (size, *colour, *sum(places, ())))):
        return None
    return {
        'kind': 'lines' if marker.type == LINE_STRIP else 'discs',
        'robot': topics.robot_of(f'/{marker.header.frame_id.strip("/")}/') or 0,
        'places': [
            [round(min(max(part, -_FARTHEST_M), _FARTHEST_M), 4) for part in place]
            for place in places
        ],
        'size': round(min(max(abs(size), _LEAST_M), _FARTHEST_M), 4),
        'colour': colour_code(colour[:3]),
        'alpha': round(min(max(colour[3], 0.0), 1.0), 3),
    }


class MarkerStore:
    """Shapes by topic, namespace and id, and the changes since they were last taken.

    They are kept as JSON: a trail of thousands then takes a fifth of the memory.
    """

    def __init__(self) -> None:
        self._shapes: dict[Key, bytes] = {}
        self._changes: dict[Key, bytes | None] = {}

    def __len__(self) -> int:
        return len(self._shapes)

    def put(self, topic: str, marker: Any) -> None:
        """Add a visualization_msgs/Marker of a topic, or replace the one with its id."""
        found = planar_shape(marker)
        key, encoded = (topic, marker.ns, marker.id), msgspec.json.encode(found)
        if found and encoded != self._shapes.get(key):
            self._shapes.pop(key, None)  # to the end of the order
            self._shapes[key] = self._changes[key] = encoded
            if len(self._shapes) > MOST_MARKERS:
                self._drop([next(iter(self._shapes))])

    def drop_topics(self, gone: Collection[str]) -> None:
        """Drop the markers of some topics."""
        self._drop([key for key in self._shapes if key[0] in gone])

    def take_changes(self) -> list[Change]:
        """Return the changed shapes since the last call."""
        changes, self._changes = self._changes, {}
        return [
            ('\0'.join(map(str, key)), None if found is None else msgspec.Raw(found))
            for key, found in changes.items()
        ]

    def _drop(self, keys: Iterable[Key]) -> None:
        for key in keys:
            del self._shapes[key]
            self._changes[key] = None
