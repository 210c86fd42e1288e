"""The bodies of a robot, much like a TurtleBot3 Burger: what has its colour, and what is dark."""

from __future__ import annotations

from setcmas_tools.view.scene.meshes import (
    Mesh,
    box,
    cylinder,
    merged,
    moved,
    prism,
    ring,
    turned_to_y,
)

HEIGHT_M = 0.192
"""Of a Burger, up to the top of its laser scanner."""

_WHEEL_RADIUS = 0.033
_PLATE = [(0.069, -0.035), (0.069, 0.035), (0.035, 0.069), (-0.05, 0.069), (-0.075, 0.045)]
_PLATE += [(x, -y) for x, y in reversed(_PLATE[2:])]
_NOSE = [(0.069, -0.05), (0.15, 0.0), (0.069, 0.05)]


def coloured_body() -> Mesh:
    """Return the three plates and a nose that shows the heading."""
    plates = [prism(_PLATE, bottom, bottom + 0.035) for bottom in (0.02, 0.07, 0.12)]
    return merged(*plates, prism(_NOSE, 0.02, 0.155))


def dark_body() -> Mesh:
    """Return wheels, posts, and the laser scanner on top."""
    wheel = turned_to_y(cylinder(_WHEEL_RADIUS, -0.009, 0.009))
    wheels = [moved(wheel, 0.0, side * 0.08, _WHEEL_RADIUS) for side in (-1, 1)]
    core = box((-0.055, 0.05), (-0.05, 0.05), (0.03, 0.13))
    return merged(*wheels, core, cylinder(0.036, 0.155, HEIGHT_M))


def unit_ring() -> Mesh:
    """Return a thin flat ring of radius 1 m around a robot."""
    return ring(0.94, 1.0, 0.008)
