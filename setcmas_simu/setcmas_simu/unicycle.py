"""One integration step of the unicycle."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    x, y, theta = np.asarray(poses, dtype=float)
    travel = Ts * np.asarray(V, dtype=float)
    heading = theta + Ts * np.asarray(omega, dtype=float)
    return np.stack((x + travel * np.cos(heading), y + travel * np.sin(heading), heading))
