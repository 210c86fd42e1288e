"""Shape of a robot for plots, films and the page; it points along the x axis at heading 0."""

from __future__ import annotations

import math
from dataclasses import dataclass

Points = tuple[tuple[float, float], ...]

_DISC_CORNERS = 32
"""Corners (x, y) in m."""


@dataclass(frozen=True)
class Prism:
    """An upright part of a robot.

    Attributes:
        outline: Its corners from above, convex, counter-clockwise.
        bottom: Height of its bottom in m.
        top: Height of its top in m.
        dark: Whether it is dark; otherwise it has the robot's colour.
    """

    outline: Points
    bottom: float
    top: float
    dark: bool = False


@dataclass(frozen=True)
class Wheel:
    """A wheel that rolls along the x axis: its centre, radius and width in m."""

    x: float
    y: float
    radius: float
    width: float


@dataclass(frozen=True)
class Shape:
    """Outline and parts of a robot.

    Attributes:
        outline: Its corners from above, for plots and films; may be concave.
        prisms: Its parts, for the page and RViz.
        wheels: Its wheels.
    """

    outline: Points
    prisms: tuple[Prism, ...]
    wheels: tuple[Wheel, ...] = ()

    @property
    def height(self) -> float:
        """Height in m of its highest part."""
        return max(prism.top for prism in self.prisms)


def rectangle(x: tuple[float, float], y: tuple[float, float]) -> Points:
    """Return the corners of a rectangle, from its range in x and in y, in m."""
    return ((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1]))


def disc(radius: float, x: float = 0.0) -> Points:
    """Return the corners of a disc centred on the x axis, all in m."""
    angles = [math.tau * i / _DISC_CORNERS for i in range(_DISC_CORNERS)]
    return tuple((x + radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


def mirrored(points: Points) -> Points:
    """Return a counter-clockwise outline from its half with y >= 0, front first."""
    return (*points, *((x, -y) for x, y in reversed(points) if y > 0))
