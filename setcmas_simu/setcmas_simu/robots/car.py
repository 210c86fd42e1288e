"""The car: it cannot turn on the spot or on a circle smaller than its steering allows."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import Motion, Prism, RobotModel, Shape, Wheel, mirrored, rectangle

WHEELBASE = 0.33
"""Distance between the axles in m, for a car on a scale of 1:10 (F1TENTH)."""

STEERING_MAX = 0.4189
"""Largest steering angle in rad, as in F1TENTH's simulator (s_max)."""

SMALLEST_RADIUS = WHEELBASE / math.tan(STEERING_MAX)
"""Radius in m of the smallest circle that the rear axle can follow: 0.74."""

_FRONT, _REAR = WHEELBASE + 0.1, -0.1
_HALF = 0.12
_WHEELS = tuple(Wheel(x, side * _HALF, 0.055, 0.05) for x in (0.0, WHEELBASE) for side in (-1, 1))
_BODY = mirrored(((_FRONT, 0.07), (_FRONT - 0.05, _HALF), (_REAR, _HALF)))


def _with_wheels() -> tuple[tuple[float, float], ...]:
    """Return the left half of the body's outline, including its wheels."""
    half = [(_FRONT, 0.07), (_FRONT - 0.045, _HALF)]
    for wheel in reversed(_WHEELS[1::2]):
        outer = wheel.y + 0.5 * wheel.width
        for x in (wheel.x + wheel.radius, wheel.x - wheel.radius):
            corners = [(x, _HALF), (x, outer)]
            half += corners if x > wheel.x else reversed(corners)
    return (*half, (_REAR, _HALF))


class Car(RobotModel):
    """Car: a kinematic bicycle, seen from its rear axle, with a minimum turning radius.

    Its turn rate is V tan(delta) / L with steering angle delta and wheelbase L, so that
    |omega| <= |V| / R (Siciliano et al., Robotics, 2009, section 11.2.2).
    """

    motion = Motion.OTHER
    shape = Shape(
        mirrored(_with_wheels()),
        (
            Prism(_BODY, 0.03, 0.1),
            Prism(rectangle((-0.05, 0.25), (-0.075, 0.075)), 0.1, 0.13, dark=True),
            Prism(rectangle((-0.03, 0.19), (-0.07, 0.07)), 0.13, 0.16),
        ),
        _WHEELS,
    )

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return the unicycle's commands, with turn rates limited by the steering."""
        commands = super().command(velocities, poses, komega)
        commands[2] = _steered(commands[0], commands[2])
        return commands

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        V, omega = commands[0], commands[2]
        return unicycle.driven(states, V, _steered(V, omega), Ts)


def _steered(V: Floats, omega: Floats) -> Floats:
    most = np.abs(V) / SMALLEST_RADIUS
    steered: Floats = np.clip(omega, -most, most)
    return steered


CAR = Car()
"""A car on a scale of 1:10, without a speed limit."""
