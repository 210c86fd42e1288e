"""Consensus: all robots meet at the average of their positions.

Each robot moves towards the average position of itself and its neighbours:

    v_i = -K / (1 + sum_j a_ij) sum_j a_ij (p_i - p_j)

where a_ij are the weights of the graph. In the complete graph the gain is K/N, and the
positions converge to their average at the rate K.
Source: Olfati-Saber and Murray, Consensus problems in networks of agents with switching topology
and time-delays, IEEE Transactions on Automatic Control 49(9), 2004; the gain of a neighbourhood as
in Jadbabaie, Lin and Morse, Coordination of groups of mobile autonomous agents using nearest
neighbor rules, IEEE Transactions on Automatic Control 48(6), 2003.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

K = 0.5  # gain (1/s)
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards its neighbours."""
    weights = network.adjacency()[robotNo - 1]
    positions = poses[:2]
    gaps = positions[:, robotNo - 1, None] - positions
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    vx, vy = -K / (1 + weights.sum()) * gaps @ weights
    return dead_band(vx, vy, SLOW)
