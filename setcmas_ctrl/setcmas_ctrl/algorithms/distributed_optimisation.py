"""Distributed optimisation: robots meet where the sum of their private costs is least.

    p_i' = -alpha q_i (p_i - c_i) - beta sum_j a_ij (p_i - p_j) - v_i
    v_i' = alpha beta sum_j a_ij (p_i - p_j), a memory with v_i(0) = 0

Robot i alone knows its cost q_i |p - c_i|^2 / 2, where c_i is the place where it starts. In an
undirected connected graph all meet at sum_i q_i c_i / sum_i q_i, the minimiser of the sum of all
costs. Without memory they stop apart, at inv(alpha Q + beta L) alpha Q c with Q = diag(q_i).
Source: Kia, Cortes and Martinez, Distributed convex optimization via continuous-time coordination
algorithms with discrete-time communication, Automatica 55, 2015; Wang and Elia, Control approach
to distributed optimization, Allerton Conference on Communication, Control, and Computing, 2010.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

Q = [1.0, 2.0, 4.0]  # weights q_i of the costs of robots 1, 2, ..., repeated for further robots
ALPHA = 0.2  # gain of the costs (1/s)
BETA = 0.2  # gain of the gaps to neighbours (1/s)
MEMORY = True  # whether robots have the memory v_i
SLOW = 0.01  # speed (m/s) below which robots stop

centre = None  # c_i (m)
memory = rise = np.zeros(2)  # v_i (m/s), and its rate of change since the call before (m/s^2)
before = 0.0  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the robot's centre and its neighbours."""
    global centre, memory, rise, before
    position = poses[:2, robotNo - 1].copy()
    if centre is None:
        centre, before = position, t
    period, before = t - before, t
    memory = memory + period * rise
    gaps = position[:, None] - poses[:2]
    gaps[np.isnan(gaps)] = 0.0  # of robots from which it has received nothing
    pull = BETA * gaps @ network.adjacency()[robotNo - 1]
    rise = MEMORY * ALPHA * pull
    vx, vy = -ALPHA * Q[(robotNo - 1) % len(Q)] * (position - centre) - pull - memory
    return dead_band(vx, vy, SLOW)
