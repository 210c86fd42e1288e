"""Finite-time consensus: robots meet within a time that can be computed in advance.

    v_i = K sum_j a_ij sig(p_j - p_i)^alpha, sig(x)^alpha = sign(x) |x|^alpha for each coordinate

with 0 < alpha < 1 on an undirected connected graph. They meet at their mean after
T <= 4 V^((1 - alpha)/2) / (K (1 - alpha) (4 lambda_2)^((1 + alpha)/2)), where lambda_2 is that of
the graph with weights a_ij^(2/(1 + alpha)), and V is half the sum of squared distances from the
mean, in the coordinate where it is larger. Near the mean the gain grows without bound, so
unicycles, and laws called at a low rate, keep oscillating by a few centimetres.
Source: Wang and Xiao, Finite-time consensus problems for networks of dynamic agents, IEEE
Transactions on Automatic Control 55(4), 2010.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

K = 0.2  # gain (m^(1 - alpha)/s)
ALPHA = 0.5  # exponent
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards its neighbours."""
    if not 0 < ALPHA < 1:
        raise ValueError(f'ALPHA = {ALPHA:g}; it must be above 0 and below 1')
    weights = network.adjacency()[robotNo - 1]
    gaps = poses[:2] - poses[:2, robotNo - 1, None]
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    vx, vy = K * (np.sign(gaps) * np.abs(gaps) ** ALPHA) @ weights
    return dead_band(vx, vy, SLOW)
