"""Drawing by control scripts, which import `rviz_marker` and `rviz_marker_array` by these names.

Arguments are checked, and spheres passed to the canvas of the process.
"""

from __future__ import annotations

import re
import types
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


def _drawing_module(name: str, is_trail: bool, summary: str) -> types.ModuleType:
    """Return a module for scripts whose function `publish_marker` draws."""

    def publish_marker(
        x: float,
        y: float,
        z: float,
        robotNo: int,
        color: Sequence[float] = (0.25, 0.25, 0.25),
        scale: float = 0.2,
        marker_name: str = 'ref',
        alpha: float = 0.5,
    ) -> None:
        """Show a sphere on /tb3_i/<marker_name>; offline runs write it to drawings.csv.

        Args:
            x: Position of the centre in the world frame, in m.
            y: As x.
            z: As x.
            robotNo: Number of the marker's robot.
            color: Red, green and blue, each in [0, 1].
            scale: Diameter in m.
            marker_name: Last part of the topic name, such as 'wp_ref'.
            alpha: Opacity in [0, 1].

        Raises:
            TypeError: A value is invalid.
            ValueError: The topic belongs to the robot itself.
        """
        shown = sphere(x, y, z, scale, color, alpha)
        robot, topic = _checked_topic(robotNo, marker_name)
        if _canvas:
            (_canvas.extend_trail if is_trail else _canvas.show)(robot, topic, shown)

    publish_marker.__qualname__ = 'publish_marker'  # in Python's messages about arguments
    module = types.ModuleType(name, summary)
    vars(module)['publish_marker'] = publish_marker
    return module


rviz_marker = _drawing_module('rviz_marker', False, 'One marker, which the next call moves.')
rviz_marker_array = _drawing_module(
    'rviz_marker_array', True, 'A trail of markers, which keeps the last 500.'
)
