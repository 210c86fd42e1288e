"""The omnidirectional robot: moves in any direction at once, whatever its heading."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import Motion, RobotModel, Shape, disc

_BODY = disc(0.12)
# From above: the disc, with a nose instead of its front corners.
_OUTLINE = ((0.16, 0.0), *(corner for corner in _BODY if corner[0] < 0.105))


class Omnidirectional(RobotModel):
    """Omnidirectional: moves in any direction at once, on Swedish or mecanum wheels.

    A single integrator with a heading (Siciliano et al., Robotics, 2009, section 11.2), which
    only turns on command.
    """

    motion = Motion.FREE
    shape = Shape(_OUTLINE, _BODY, 0.15)

    def command(self, velocities: Floats, poses: Floats, komega: float) -> Floats:
        """Return velocities (2, N) in the robots' frames; those that are not finite become 0."""
        del komega  # the heading needs no control
        known = np.isfinite(velocities).all(axis=0) & np.isfinite(poses[2])
        vx, vy = np.where(known, velocities, 0.0)
        theta = np.where(known, poses[2], 0.0)
        cos, sin = np.cos(theta), np.sin(theta)
        return np.stack([cos * vx + sin * vy, cos * vy - sin * vx, np.zeros_like(vx)])

    def step(self, states: Floats, commands: Floats, Ts: float) -> Floats:
        """Return the states one period later, the heading first, as for the unicycle."""
        forward, left, omega = commands
        later: Floats = states.copy()
        later[2] += Ts * omega
        cos, sin = np.cos(later[2]), np.sin(later[2])
        later[0] += Ts * (cos * forward - sin * left)
        later[1] += Ts * (sin * forward + cos * left)
        later[3:6] = commands
        return later


OMNIDIRECTIONAL = Omnidirectional()
"""Without limits, like the unicycle."""
