"""The car: it cannot turn on the spot or on a circle smaller than its steering allows."""

from __future__ import annotations

import math

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots import unicycle
from setcmas_simu.robots.model import Motion, RobotModel, Shape, mirrored

WHEELBASE = 0.33
"""Distance between the axles in m, for a car on a scale of 1:10 (F1TENTH)."""

STEERING_MAX = 0.4189
"""Largest steering angle in rad, as in F1TENTH's simulator (s_max)."""

SMALLEST_RADIUS = WHEELBASE / math.tan(STEERING_MAX)
"""Radius in m of the smallest circle that the rear axle can follow: 0.74."""

_FRONT, _REAR = WHEELBASE + 0.1, -0.1
_HALF = 0.12
_RIM, _OUTER = 0.055, _HALF + 0.025  # radius of the wheels, and their outer side
_BODY = mirrored(((_FRONT, 0.07), (_FRONT - 0.05, _HALF), (_REAR, _HALF)))
_LEFT_WHEELS = (
    (axle + side * _RIM, y)
    for axle in (WHEELBASE, 0.0)
    for side, y in ((1, _HALF), (1, _OUTER), (-1, _OUTER), (-1, _HALF))
)
_OUTLINE = mirrored(
    ((_FRONT, 0.07), (_FRONT - 0.045, _HALF), *_LEFT_WHEELS, (_REAR, _HALF)),
)


class Car(RobotModel):
    """Car: a kinematic bicycle, seen from its rear axle, with a minimum turning radius.

    Its turn rate is V tan(delta) / L with steering angle delta and wheelbase L, so that
    |omega| <= |V| / R (Siciliano et al., Robotics, 2009, section 11.2.2).
    """

    motion = Motion.OTHER
    shape = Shape(_OUTLINE, _BODY, 0.16)

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later."""
        V, omega = commands[0], commands[2]
        most = np.abs(V) / SMALLEST_RADIUS
        return unicycle.driven(states, V, np.clip(omega, -most, most), Ts)


CAR = Car()
"""A car on a scale of 1:10, without a speed limit."""
