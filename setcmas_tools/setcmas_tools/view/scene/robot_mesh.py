"""Bodies of a robot: the coloured and the dark ones."""

from __future__ import annotations

from setcmas_simu.robots.model import Shape
from setcmas_tools.view.scene.meshes import (
    Mesh,
    cylinder,
    merged,
    moved,
    prism,
    ring,
    turned_to_y,
)


def drawn_size(real: bool) -> float:
    """Return how many times larger than they are robots are drawn, unless somebody asks."""
    return 1.0 if real else 2.5


def coloured_body(shape: Shape) -> Mesh:
    """Return the parts of a robot that have its colour."""
    return _prisms(shape, dark=False)


def dark_body(shape: Shape) -> Mesh:
    """Return the dark parts of a robot, and its wheels."""
    wheels = [
        moved(
            turned_to_y(cylinder(wheel.radius, -0.5 * wheel.width, 0.5 * wheel.width)),
            wheel.x,
            wheel.y,
            wheel.radius,
        )
        for wheel in shape.wheels
    ]
    return merged(*wheels, _prisms(shape, dark=True))


def _prisms(shape: Shape, dark: bool) -> Mesh:
    parts = [part for part in shape.prisms if part.dark == dark]
    return merged(*(prism(list(part.outline), part.bottom, part.top) for part in parts))


def unit_ring() -> Mesh:
    """Return a thin flat ring of radius 1 m around a robot."""
    return ring(0.94, 1.0, 0.008)
