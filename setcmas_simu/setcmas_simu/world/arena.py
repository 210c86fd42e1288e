"""Arena: the box in which robots may move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import Any, NamedTuple

from setcmas_simu.options.kinds import Kind


class Arena(NamedTuple):
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


@dataclass(frozen=True)
class Borders(Kind):
    """Borders of an arena as an option."""

    metavar: str | None = field(default='XMIN,XMAX,YMIN,YMAX', kw_only=True)

    @property
    def must_be(self) -> str:
        """The form, with an example."""
        return 'XMIN,XMAX,YMIN,YMAX in m, minimum first, such as --arena=-2,2,-1.5,1.5'

    def parse(self, text: str) -> Arena | str:
        """Return the arena in a text; malformed text as it is."""
        try:
            arena = Arena(*map(float, text.split(',')))
        except (TypeError, ValueError):
            return text
        return arena if self.accepts(arena) else text

    def accepts(self, value: Any) -> bool:
        """Return whether a value has the four borders of a box of positive size."""
        if not isinstance(value, Sequence) or len(value) != 4:
            return False
        if not all(isinstance(end, Real) and math.isfinite(end) for end in value):
            return False
        xmin, xmax, ymin, ymax = value
        return bool(xmin < xmax and ymin < ymax)

    def text(self, value: Any) -> str:
        """Return the borders as text."""
        return ','.join(map(repr, value))
