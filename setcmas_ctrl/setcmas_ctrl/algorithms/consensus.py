"""Consensus: all robots meet at the average of their positions.

Each robot moves towards the others that it hears:

    v_i = -(K/N) sum_j a_ij (p_i - p_j)

with the adjacency a_ij = 1 for every pair (complete graph). The positions converge to their
average with rate K.
Source: Olfati-Saber and Murray, Consensus problems in networks of agents with switching topology
and time-delays, IEEE Transactions on Automatic Control 49(9), 2004.
"""

import numpy as np

from setcmas_ctrl.saturation import dead_band

K = 0.5  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that leads the robot to the others."""
    positions = poses[:2]
    position = positions[:, robotNo - 1]
    adjacency = np.ones(nbRobots)
    adjacency[robotNo - 1] = 0
    vx, vy = -K / nbRobots * (position[:, None] - positions) @ adjacency
    return dead_band(vx, vy)
