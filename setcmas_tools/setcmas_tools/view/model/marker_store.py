"""Store of the markers to be seen now: added, replaced, deleted, gone when their time is up."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.view.model.marker_shapes import LINES, Shape, rotate, shape

Key = tuple[str, str, int]

ADD, DELETE, DELETE_ALL = 0, 2, 3
"""Values of visualization_msgs/Marker.action."""
MOST_MARKERS = 30_000
"""Beyond, the oldest is dropped."""


class MarkerStore:
    """Shapes by topic, namespace and id.

    Attributes:
        changed: The kinds of shapes that have changed since this set was last emptied.
    """

    def __init__(self) -> None:
        """Start without markers."""
        self._shapes: dict[Key, Shape] = {}
        self._ends: dict[Key, float] = {}
        self.changed: set[str] = set()

    def __len__(self) -> int:
        """Return the number of markers."""
        return len(self._shapes)

    def apply(self, topic: str, marker: Any, now: float) -> None:
        """Do what a Marker message asks for.

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
            self.put(key, shape(marker))
            lifetime = marker.lifetime.sec + 1e-9 * marker.lifetime.nanosec
            if lifetime > 0:
                self._ends[key] = now + lifetime
            if len(self._shapes) > MOST_MARKERS:
                self._drop([next(iter(self._shapes))])

    def put(self, key: Key, found: Shape | None) -> None:
        """Show a shape, or none, in place of what its key has shown."""
        self._drop([key])
        if found:
            self._shapes[key] = found
            self.changed.add(found.kind)

    def expire(self, now: float) -> None:
        """Drop the markers whose lifetime is over."""
        self._drop([key for key, end in self._ends.items() if end <= now])

    def drop_topics(self, gone: Collection[str]) -> None:
        """Drop the markers of some topics."""
        self._drop([key for key in self._shapes if key[0] in gone])

    def clear(self) -> None:
        """Drop all markers."""
        self._drop(list(self._shapes))

    def of_kind(self, kind: str) -> Iterator[tuple[Key, Shape]]:
        """Yield the shapes of a kind."""
        return ((key, found) for key, found in self._shapes.items() if found.kind == kind)

    def solids(self, kind: str, poses: dict[int, tuple[float, float, float]]) -> Floats:
        """Return all rows of a kind in the world frame, as `Shape.rows` tells; shape (n, 14).

        Args:
            kind: One of `SOLIDS`.
            poses: x, y (m) and theta (rad) of the robots; what is in another frame is left out.
        """
        rows = [
            found.rows if not found.robot else _in_world(found.rows, poses[found.robot])
            for _, found in self.of_kind(kind)
            if not found.robot or found.robot in poses
        ]
        return np.concatenate([np.empty((0, 14)), *rows])

    def segments(self, kind: str) -> dict[float, Floats]:
        """Return lines in the world frame by their thickness in m, each of shape (n, 12)."""
        by_thickness: defaultdict[float, list[Floats]] = defaultdict(list)
        for _, found in self.of_kind(kind):
            if not found.robot:
                by_thickness[round(found.thickness, 3)].append(found.rows)
        return {thickness: np.concatenate(rows) for thickness, rows in by_thickness.items()}

    def reach(self) -> float:
        """Return how far lines go from the origin along x or y, in m, such as an arena's."""
        ends = [
            np.abs(found.rows[:, [0, 1, 3, 4]]).max()
            for _, found in self.of_kind(LINES)
            if not found.robot
        ]
        return float(max(ends, default=0.0))

    def moves(self, kind: str) -> bool:
        """Return whether some shape of a kind is in a robot's frame."""
        return any(found.robot for _, found in self.of_kind(kind))

    def _drop(self, keys: list[Key]) -> None:
        for key in keys:
            self._ends.pop(key, None)
            if found := self._shapes.pop(key, None):
                self.changed.add(found.kind)


def _in_world(rows: Floats, pose: tuple[float, float, float]) -> Floats:
    """Return rows of solids in a robot's frame as rows in the world frame."""
    x, y, theta = pose
    turn = np.array([np.cos(theta / 2), 0.0, 0.0, np.sin(theta / 2)])
    result: Floats = rows.copy()
    result[:, :3] = rotate(turn, rows[:, :3]) + np.array([x, y, 0.0])
    w, i, j, k = rows[:, 3:7].T
    c, s = turn[0], turn[3]
    result[:, 3:7] = np.column_stack([c * w - s * k, c * i - s * j, c * j + s * i, c * k + s * w])
    return result
