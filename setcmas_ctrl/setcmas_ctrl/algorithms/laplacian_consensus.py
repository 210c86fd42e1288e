"""Laplacian consensus: the graph's Laplacian determines where and how fast robots meet.

    v_i = -K sum_j a_ij (p_i - p_j), together p' = -K L p

In an undirected connected graph they meet at the mean of their starts at the rate K lambda_2. In a
directed graph in which some robot reaches all others they meet at w' p(0) with w' L = 0 and
w' 1 = 1, which is the mean if and only if the graph is balanced.

If the neighbours' positions are late by tau, robots of an undirected graph meet at
sum_i (1 + K d_i tau) p_i(0) / sum_i (1 + K d_i tau) with d_i = sum_j a_ij, for any tau. If their
own position is as late (DELAY = tau), they meet if and only if K lambda_N tau < pi/2.
Source: Olfati-Saber and Murray, Consensus problems in networks of agents with switching topology
and time-delays, IEEE Transactions on Automatic Control 49(9), 2004; directed graphs: Ren and
Beard, Consensus seeking in multiagent systems under dynamically changing interaction topologies,
IEEE Transactions on Automatic Control 50(5), 2005.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

K = 0.2  # gain (1/s)
DELAY = 0.0  # age (s) of the own position that the law uses
SLOW = 0.01  # speed (m/s) below which robots stop

past = []  # times (s) and own positions (m), from the one that the law uses on


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards its neighbours."""
    if DELAY < 0:
        raise ValueError(f'DELAY = {DELAY:g} s; it must be 0 s or more')
    past.append((t, poses[:2, robotNo - 1].copy()))
    while len(past) > 1 and past[1][0] < t - DELAY + 1e-9:
        del past[0]
    weights = network.adjacency()[robotNo - 1]
    gaps = past[0][1][:, None] - poses[:2]
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    vx, vy = -K * gaps @ weights
    return dead_band(vx, vy, SLOW)
