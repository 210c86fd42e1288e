"""Containment: followers converge to the convex hull of stationary leaders.

    v_i = 0 for leaders, v_i = -K sum_j a_ij (p_i - p_j) for followers

With L = [L_FF L_FL; 0 0] followers converge to -inv(L_FF) L_FL p_L, in the convex hull of the
leaders, if some leader reaches each of them; the rate is K times the smallest eigenvalue of L_FF.
Source: Ji, Ferrari-Trecate, Egerstedt and Buffa, Containment control in mobile networks, IEEE
Transactions on Automatic Control 53(8), 2008.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

K = 0.3  # gain (1/s)
LEADERS = [1, 2, 3]  # robots that stand still
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of a leader or of a follower."""
    if robotNo in LEADERS:
        return 0.0, 0.0
    weights = network.adjacency()[robotNo - 1]
    gaps = poses[:2, robotNo - 1, None] - poses[:2]
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    vx, vy = -K * gaps @ weights
    return dead_band(vx, vy, SLOW)
