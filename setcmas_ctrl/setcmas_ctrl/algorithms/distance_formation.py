"""Distance formation: robots keep the distances of a shape to their neighbours.

    v_i = -K sum_j a_ij (|p_i - p_j|^2 - |P_i - P_j|^2) (p_i - p_j)

with the points P of the shape. In an undirected graph this is gradient descent, and the centre of
the robots stays. If the graph is infinitesimally rigid (the rigidity matrix R, with a row z_ij',
-z_ij' for each link, has rank 2 N - 3), robots that start near the shape form it at the rate
2 K lambda with the smallest eigenvalue lambda > 0 of R R', turned or mirrored. From distant starts
they may end elsewhere, with parts of the shape mirrored.
Source: Krick, Broucke and Francis, Stabilisation of infinitesimally rigid formations of
multi-robot networks, International Journal of Control 82(3), 2009.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'distances'  # selects its metrics and plots

K = 0.02  # gain (1/(m^2 s))
P = None  # points of the shape (m); by default a regular polygon with a radius of 2 m
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that corrects the distances to neighbours."""
    points, weights = shape(nbRobots), network.adjacency()[robotNo - 1]
    gaps = poses[:2, robotNo - 1] - poses[:2].T
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    errors = np.sum(gaps**2, axis=1) - np.sum((points[robotNo - 1] - points) ** 2, axis=1)
    vx, vy = -K * (weights * errors) @ gaps
    return dead_band(vx, vy, SLOW)


def shape(nbRobots):
    """Return the points of the shape in m, shape (N, 2)."""
    angles = -2 * np.pi * np.arange(nbRobots) / nbRobots
    points = 2 * np.column_stack([np.cos(angles), np.sin(angles)]) if P is None else np.array(P)
    if len(points) < nbRobots:
        raise ValueError(f'P has {len(points)} points for {nbRobots} robots')
    return points[:nbRobots]


def references(nbRobots):
    """Return the shape, whose distances the metrics compare with those of the robots."""
    return {'D': shape(nbRobots).tolist()}
