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
from setcmas_ctrl.control.prediction import LinearLaw, Predicted
from setcmas_ctrl.control.saturation import dead_band

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


def stiffness(adjacency):
    """Return R'R of the rigidity matrix R of the shape, shape (2 N, 2 N)."""
    ends = np.eye(len(adjacency))[np.argwhere(np.triu(adjacency + adjacency.T))]
    incidence = ends[:, 0] - ends[:, 1]
    rows = incidence[:, :, None] * (incidence @ shape(len(adjacency)))[:, None]
    return np.tensordot(rows, rows, (0, 0)).reshape(2 * len(adjacency), -1)


def doubts(conditions):
    """Yield why robots may form another shape."""
    stiff = stiffness(conditions.adjacency)
    if np.linalg.matrix_rank(stiff) < max(len(stiff) - 3, 1):
        yield 'the graph at the start is not rigid: robots may form another shape'
    yield from LinearLaw(2 * K * stiff, "2 K R'R").doubts(conditions.period, meet=False)


def predict(conditions):
    """Return the centre in an undirected graph, and the size of the shape if it is rigid."""
    adjacency, points = conditions.adjacency, shape(len(conditions.adjacency))
    if len(points) < 2 or (adjacency != adjacency.T).any():
        return {}
    found = {
        f'consensus.final_centre_{axis}_m': Predicted(place, 'sum_i v_i = 0')
        for axis, place in zip('xy', conditions.starts[:2].mean(axis=1), strict=True)
    }
    rates = 2 * K * np.linalg.eigvalsh(stiffness(adjacency))
    if rates[3] * conditions.duration > 10 and rates[-1] * conditions.period < 2:
        largest = np.linalg.norm(points[:, None] - points, axis=-1).max()
        found['separation.largest_distance_at_end_m'] = Predicted(largest, 'the shape P')
    return found
