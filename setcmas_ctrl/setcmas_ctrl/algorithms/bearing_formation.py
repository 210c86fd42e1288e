"""Bearing formation: the directions of links determine a shape; its size and place are free.

    v_i = -K sum_j a_ij (I - g_ij g_ij') (p_i - p_j), g_ij = (P_i - P_j) / |P_i - P_j|

with the points P of the shape; together p' = -K B p with the bearing Laplacian B. If the graph is
undirected and infinitesimally bearing rigid (B has rank 2 N - 3), robots converge to the
projection of their starts onto all translated and scaled shapes, at the rate K lambda with the
smallest eigenvalue lambda > 0 of B. With the centre c of the robots, which stays, and C of P:

    p_i - c -> s (P_i - C), s = sum_j (p_j(0) - c)' (P_j - C) / sum_j |P_j - C|^2

A negative s turns the shape by 180 degrees. All robots use the same directions of axes.
Source: Zhao and Zelazo, Translational and scaling formation maneuver control via a bearing-based
approach, IEEE Transactions on Control of Network Systems 4(3), 2017.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

K = 0.2  # gain (1/s)
P = None  # points of the shape (m); by default a regular polygon
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that corrects the directions to neighbours."""
    gaps = poses[:2, robotNo - 1, None] - poses[:2]
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    normal = normals(nbRobots)[:, robotNo - 1]  # I - g g' = n n'
    vx, vy = -K * normal @ (network.adjacency()[robotNo - 1] * np.sum(normal * gaps, axis=0))
    return dead_band(vx, vy, SLOW)


def normals(nbRobots):
    """Return unit vectors across the directions of the shape, rows x and y, shape (2, N, N)."""
    angles = -2 * np.pi * np.arange(nbRobots) / nbRobots
    points = np.array([np.cos(angles), np.sin(angles)] if P is None else np.transpose(P))
    if points.shape[1] < nbRobots:
        raise ValueError(f'P has {points.shape[1]} points for {nbRobots} robots')
    x, y = points[:, :nbRobots, None] - points[:, None, :nbRobots]
    lengths = np.hypot(x, y)
    return np.array([-y, x]) / np.where(lengths > 0, lengths, 1)
