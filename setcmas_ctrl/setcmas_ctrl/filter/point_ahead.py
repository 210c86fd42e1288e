"""A point ahead of a unicycle's axle: its velocity, and the commands that give it one."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats

LOOKAHEAD_M = 0.05
"""Default distance of the point from the axle, in m."""


def velocities_of_points(commands: Floats, theta: Floats, ahead: Floats, Ts: float) -> Floats:
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


def commands_of_points(
    velocities: Floats, theta: Floats, ahead: Floats | float, Ts: float
) -> Floats:
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
