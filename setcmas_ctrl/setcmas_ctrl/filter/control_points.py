"""Control points of the safety filter: a robot's centre, or a point ahead of a unicycle's axle."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from setcmas_ctrl.filter.barrier_constraints import Constraints
from setcmas_ctrl.filter.filter_options import LOOKAHEAD_M
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.model import Motion, RobotModel

_FASTEST_TURN = 2.6
"""Turn rate limit in rad/s for robots without limits: that of a TurtleBot3 Burger."""


def check_motions(models: Sequence[RobotModel]) -> None:
    """Check that the filter can handle the motion of a fleet, or raise SetcmasError."""
    others = [robot for robot, model in enumerate(models, 1) if model.motion is Motion.OTHER]
    if others:
        raise SetcmasError(
            'the safety filter needs robots that turn on the spot or move in any direction; '
            f'{robots_in_words(others)} cannot: use --filter none or another --model'
        )


class ControlPoints:
    """Control points of a fleet of N robots.

    Attributes:
        ahead: Distance from each robot's centre to its control point in m, shape (N,).
        V_max: Speed limit of each robot in m/s, shape (N,).
    """

    def __init__(self, models: Sequence[RobotModel]) -> None:
        """Choose the control points of robots by their models."""
        turns = [model.motion is Motion.UNICYCLE for model in models]
        self._turns = np.array(turns)
        self._unicycles = np.flatnonzero(self._turns)
        self.ahead = np.where(self._turns, LOOKAHEAD_M, 0.0)
        limits = [model.limits for model, turns in zip(models, turns, strict=True) if turns]
        self._turn_max = np.array([min(limit.omega_max, _FASTEST_TURN) for limit in limits])
        self._wheel_max = np.array([limit.wheel_speed_max for limit in limits])
        self._lever = np.array([0.5 * limit.wheel_separation / LOOKAHEAD_M for limit in limits])
        self.V_max = np.array([model.V_max for model in models])

    def points(self, poses: Floats) -> Floats:
        """Return the control points (2, N) at poses (3, N)."""
        return poses[:2] + self.ahead * along(poses[2])

    def driven(self, commands: Floats, poses: Floats) -> Floats:
        """Return the velocities (2, N) of the robots' centres under commands (3, N)."""
        return _rotated(commands[:2], poses[2])

    def velocities(self, wanted: Floats, commands: Floats, poses: Floats, Ts: float) -> Floats:
        """Return the velocities of the control points, (2, N).

        Robots that move in any direction have the wanted velocities (2, N), unicycles those of
        their commands (3, N).
        """
        moved: Floats = wanted.copy()
        moved[:, self._unicycles] = velocities_of_points(
            commands[:, self._turns], poses[2, self._unicycles], LOOKAHEAD_M, Ts
        )
        return moved

    def limits(
        self, velocities: Floats, commands: Floats, poses: Floats, Ts: float
    ) -> Constraints:
        """Return the limits of turn rates and wheels; wanted velocities satisfy them."""
        forward, left = along(poses[2, self._unicycles]), across(poses[2, self._unicycles])
        wanted = velocities[:, self._unicycles]
        turns = np.minimum(np.maximum(self._turn_max, np.abs(commands[2, self._turns])), 3.0 / Ts)
        tan = np.tan(0.5 * Ts * turns)
        parts = [(side * left - tan * forward, 2.0 * LOOKAHEAD_M * tan / Ts) for side in (1, -1)]
        if np.isfinite(self._wheel_max).all():
            parts += [
                (way * forward + side * self._lever * left, self._wheel_max)
                for way in (1, -1)
                for side in (1, -1)
            ]
        return Constraints.stacked(
            [
                Constraints.of_single(self._unicycles, a, np.maximum(b, (a * wanted).sum(axis=0)))
                for a, b in parts
            ]
        )

    def rises(self, velocities: Floats, before: Floats, poses: Floats, most: float) -> Constraints:
        """Return the constraints that limit the rise of speeds to `most` (m/s).

        Wanted velocities (2, N) of the points within the limits satisfy them; slowing down has no
        limit. `before` are the previous commands (3, N).
        """
        theta = poses[2]
        every = np.ones_like(self._turns)
        parts = []
        for axis, last, which in (
            (along(theta), before[0], every),
            (across(theta), before[1], ~self._turns),
        ):
            share = np.where(self._turns, most, most / math.sqrt(2.0))  # worst case of two axes
            for side in (1, -1):
                a = (side * axis)[:, which]
                b = (np.maximum(0.0, side * last) + share)[which]
                wanted = (a * velocities[:, which]).sum(axis=0)
                robots = np.flatnonzero(which)
                parts.append(Constraints.of_single(robots, a, np.maximum(b, wanted)))
        return Constraints.stacked(parts)


def velocities_of_points(commands: Floats, theta: Floats, ahead: float, Ts: float) -> Floats:
    """Return the mean velocities of the points over a period with constant commands.

    In the robot's frame a point moves by V Ts sinc(phi/2) e(phi/2) + l (e(phi) - e(0)), with the
    turn phi = omega Ts and e(a) = (cos a, sin a): the exact motion on a circular arc.

    Args:
        commands: Forward speeds (m/s), speeds to the left (ignored) and turn rates (rad/s),
            shape (3, N).
        theta: Headings in rad, shape (N,).
        ahead: Distances of the points from the axles in m, above 0, shape (N,).
        Ts: Period in s.

    Returns:
        Rows vx, vy in m/s in the world frame, shape (2, N).
    """
    half = 0.5 * Ts * commands[2]
    chord = commands[0] * _sinc(half)
    turned = 2.0 / Ts * ahead * np.sin(half)
    return _rotated(chord * along(half) + turned * across(half), theta)


def commands_of_points(velocities: Floats, theta: Floats, ahead: float, Ts: float) -> Floats:
    """Return the commands that give the points constant velocities over a period.

    The inverse of `velocities_of_points`: with the displacement (a, b) of a point in the robot's
    frame, tan(phi/2) = b / (2 l + a). For a short period it becomes the near-identity
    diffeomorphism V = a / Ts, omega = b / (l Ts) (Olfati-Saber, CDC 2002).

    Returns:
        Forward speeds (m/s), zeros, and turn rates (rad/s), shape (3, N).
    """
    a, b = Ts * _rotated(velocities, -theta)
    half = np.arctan2(b, 2.0 * ahead + a)
    chord = a * np.cos(half) + b * np.sin(half)
    return np.stack([chord / (Ts * _sinc(half)), np.zeros_like(a), 2.0 * half / Ts])


def along(angles: Floats) -> Floats:
    """Return unit vectors (2, N) along headings in rad, shape (N,)."""
    return np.stack([np.cos(angles), np.sin(angles)])


def across(angles: Floats) -> Floats:
    """Return unit vectors (2, N) to the left of headings in rad, shape (N,)."""
    return np.stack([-np.sin(angles), np.cos(angles)])


def _rotated(vectors: Floats, angles: Floats) -> Floats:
    rotated: Floats = vectors[0] * along(angles) + vectors[1] * across(angles)
    return rotated


def _sinc(angles: Floats) -> Floats:
    return np.sinc(angles / np.pi)
