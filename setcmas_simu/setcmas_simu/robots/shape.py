"""The shape of a robot, as plots, films and the view draw it; along the x axis at heading 0."""

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
        bottom: Height in m at which it begins.
        top: Height in m at which it ends.
        dark: Whether it is dark instead of in the robot's colour.
    """

    outline: Points
    bottom: float
    top: float
    dark: bool = False


@dataclass(frozen=True)
class Wheel:
    """A wheel on the ground that rolls along the x axis; its middle, radius and width in m."""

    x: float
    y: float
    radius: float
    width: float


@dataclass(frozen=True)
class Shape:
    """What a robot looks like.

    Attributes:
        outline: Its corners from above, for plots and films; it need not be convex.
        prisms: Its parts, for the view and RViz.
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
    """Return the corners of a rectangle between two coordinates in each direction, in m."""
    return ((x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1]))


def disc(radius: float, x: float = 0.0) -> Points:
    """Return the corners of a disc with its middle on the x axis, all in m."""
    angles = [math.tau * i / _DISC_CORNERS for i in range(_DISC_CORNERS)]
    return tuple((x + radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


def mirrored(points: Points) -> Points:
    """Return a counter-clockwise outline made of its half at y >= 0, front first."""
    return (*points, *((x, -y) for x, y in reversed(points) if y > 0))
