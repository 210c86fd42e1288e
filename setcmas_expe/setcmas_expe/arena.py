"""Arena: the box in which robots may move."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Arena:
    """The box in which robots may move, in m."""

    xmin: float
    xmax: float
    ymin: float
    ymax: float

    def distance(self, x: float, y: float) -> float:
        """Return how far a point (m) is from the box, in m; 0 inside."""
        return math.hypot(
            max(self.xmin - x, 0.0, x - self.xmax), max(self.ymin - y, 0.0, y - self.ymax)
        )

    def outward_normals(self, x: float, y: float) -> list[tuple[float, float]]:
        """Return the outward unit normal of each side that a point (m) is beyond."""
        sides = (
            (x > self.xmax, (1.0, 0.0)),
            (x < self.xmin, (-1.0, 0.0)),
            (y > self.ymax, (0.0, 1.0)),
            (y < self.ymin, (0.0, -1.0)),
        )
        return [normal for beyond, normal in sides if beyond]
