"""Drawing by control scripts: checks arguments, and passes spheres to the process's canvas."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, Protocol

from setcmas_simu.fleet import topics

_NAME = re.compile(r'[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)
"""Names of topics within a robot's namespace."""


class Sphere(NamedTuple):
    """A sphere in the world frame: centre and diameter in m, colour and opacity in [0, 1]."""

    x: float
    y: float
    z: float
    diameter: float
    colour: tuple[float, ...]
    alpha: float


def sphere(
    x: float, y: float, z: float, diameter: float, colour: Sequence[float], alpha: float
) -> Sphere:
    """Return a sphere from a script's arguments; checked alike with and without ROS.

    Raises:
        TypeError: A value is not a number, or the colour has not three numbers.
    """
    try:
        red, green, blue = map(float, colour)
        return Sphere(
            float(x), float(y), float(z), float(diameter), (red, green, blue), float(alpha)
        )
    except (TypeError, ValueError):
        raise TypeError(
            f'publish_marker got x={x!r}, y={y!r}, z={z!r}, color={colour!r}, scale={diameter!r}, '
            f'alpha={alpha!r}; must be numbers, and color [red, green, blue] from 0 to 1'
        ) from None


def _checked_topic(robot: int, name: str) -> tuple[int, str]:
    """Check the robot and the topic name that a script draws on, and return them.

    Raises:
        TypeError: They are invalid.
        ValueError: The topic belongs to the robot itself.
    """
    try:
        number = int(robot)
        if number != float(robot) or number < 1 or not _NAME.fullmatch(name):
            raise ValueError
    except (TypeError, ValueError):
        raise TypeError(
            f'publish_marker got robotNo={robot!r}, marker_name={name!r}; must be a robot number '
            "and a name of letters, digits and _, such as 'wp_ref'"
        ) from None
    if name in topics.OF_ROBOT:
        raise ValueError(
            f'publish_marker got marker_name={name!r}, a topic of the robot itself; '
            "choose another name, such as 'wp_ref'"
        )
    return number, name


class Canvas(Protocol):
    """Shows spheres to the user."""

    def show(self, robot: int, name: str, sphere: Sphere) -> None:
        """Show a sphere in place of the previous one of this robot and name."""

    def extend_trail(self, robot: int, name: str, sphere: Sphere) -> None:
        """Add a sphere to the trail of this robot and name."""


_canvas: Canvas | None = None


@contextmanager
def drawn_on(canvas: Canvas) -> Iterator[None]:
    """Show what scripts draw on a canvas, inside; elsewhere nothing is shown."""
    global _canvas
    before, _canvas = _canvas, canvas
    try:
        yield
    finally:
        _canvas = before


def draw(robot: int, name: str, what: Sphere, trail: bool = False) -> None:
    """Show a sphere on the topic of a robot, in place of the one before or as part of a trail.

    Raises:
        TypeError: The robot or the name is invalid.
        ValueError: The topic belongs to the robot itself.
    """
    robot, name = _checked_topic(robot, name)
    if _canvas:
        (_canvas.extend_trail if trail else _canvas.show)(robot, name, what)
