"""One integration step of the unicycle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.fleet.planar_pose import wrap_angle

RATE_HZ = 10.0
"""Default rate at which robots are integrated, in Hz."""


def step(poses: ArrayLike, V: ArrayLike, omega: ArrayLike, Ts: float) -> NDArray[np.float64]:
    """Integrate the unicycle over one period, the heading first.

    theta+ = theta + Ts omega, then x+ = x + Ts V cos(theta+) and y+ = y + Ts V sin(theta+): the
    semi-implicit Euler scheme of the kinematic unicycle (Siciliano et al., Robotics, 2009,
    section 11.2.1), in the order of the ROS 1 stack. The heading is not wrapped.

    Args:
        poses: Rows x, y in m and theta in rad, shape (3, N).
        V: Forward speeds in m/s, shape (N,).
        omega: Turn rates in rad/s, shape (N,).
        Ts: Period in s.

    Returns:
        The poses a period later, shape (3, N).
    """
    later = np.array(poses, dtype=float)
    travel = Ts * np.asarray(V, dtype=float)
    later[2] += Ts * np.asarray(omega, dtype=float)
    later[0] += travel * np.cos(later[2])
    later[1] += travel * np.sin(later[2])
    return later


def velocities_between(
    before: ArrayLike, after: ArrayLike, Ts: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the velocities that lead from poses to later ones: backward differences.

    The forward speed is the displacement along the later heading, as `step` would have made it;
    any sideways displacement is left out.

    Args:
        before: Rows x, y in m and theta in rad, shape (3,) or (3, N).
        after: The poses Ts later, the same shape.
        Ts: Time between them in s, above 0.

    Returns:
        Forward speeds in m/s and turn rates in rad/s.
    """
    x0, y0, theta0 = np.asarray(before, dtype=float)
    x1, y1, theta1 = np.asarray(after, dtype=float)
    V = ((x1 - x0) * np.cos(theta1) + (y1 - y0) * np.sin(theta1)) / Ts
    return V, wrap_angle(theta1 - theta0) / Ts
