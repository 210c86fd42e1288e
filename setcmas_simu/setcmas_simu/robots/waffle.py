"""The TurtleBot3 Waffle."""

from __future__ import annotations

from setcmas_simu.robots.shape import Prism, Shape, Wheel, disc, mirrored, rectangle
from setcmas_simu.robots.turtlebot3 import TurtleBot3
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS

# 281 x 306 x 141 mm (ROBOTIS' manual); the axle is ahead of the centre.
_PLATE = mirrored(((0.077, 0.08), (0.03, 0.131), (-0.16, 0.131), (-0.204, 0.08)))
_NOSE = ((0.077, -0.06), (0.2, 0.0), (0.077, 0.06))

WAFFLE = TurtleBot3(
    ROBOT_MODELS['waffle'],
    Shape(
        mirrored(
            (
                (0.2, 0.0),
                (0.077, 0.06),
                (0.05, 0.12),
                (0.02, 0.153),
                (-0.16, 0.153),
                (-0.204, 0.08),
            )
        ),
        (
            *(Prism(_PLATE, bottom, bottom + 0.03) for bottom in (0.02, 0.07)),
            Prism(_NOSE, 0.02, 0.1),
            Prism(rectangle((-0.16, 0.05), (-0.1, 0.1)), 0.03, 0.08, dark=True),
            Prism(disc(0.036, x=-0.064), 0.1, 0.141, dark=True),  # the laser scanner
        ),
        tuple(Wheel(0.0, side * 0.1435, 0.033, 0.018) for side in (-1, 1)),
    ),
)
"""Limits of its OpenCR firmware."""
