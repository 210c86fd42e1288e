"""Second-order consensus: robots with inertia meet if their velocities are damped enough.

    v_i' = -sum_j a_ij (K (p_i - p_j) + G (v_i - v_j)), together p'' = -K L p - G L p'

Robots send their velocities v_i, which are 0 at the start. In an undirected connected graph they
meet for any gains above 0; in a directed graph in which some robot reaches all others if and only
if G^2/K > Im(mu)^2/(Re(mu) |mu|^2) for all eigenvalues mu of L other than 0, which in a directed
ring is G^2/K > cot^2(pi/N)/2.
Source: Ren and Atkins, Distributed multi-vehicle coordinated control via local information
exchange, International Journal of Robust and Nonlinear Control 17, 2007; the condition: Yu, Chen
and Cao, Some necessary and sufficient conditions for second-order consensus in multi-agent
dynamical systems, Automatica 46(6), 2010.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

K = 0.1  # gain of positions (1/s^2)
G = 0.4  # gain of velocities (1/s)
SLOW = 0.01  # speed (m/s) below which robots stop
WAIT = 2.0  # time (s) after which a robot that receives nothing stands still

velocity = np.zeros(2)  # its own (m/s)
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s, the integral of the acceleration."""
    global velocity, before
    weights, received = network.adjacency()[robotNo - 1], network.received()
    pull = np.zeros(2)
    for j in network.neighbours():
        gap = np.nan_to_num(poses[:2, j - 1] - poses[:2, robotNo - 1])  # 0 if it is not known
        theirs = received[j].value if j in received else 0.0
        pull += weights[j - 1] * (K * gap + G * (theirs - velocity))
    h, before = t - (t if before is None else before), t
    velocity = velocity + h * pull if received or t < WAIT else np.zeros(2)
    network.send(velocity)
    return dead_band(*velocity, SLOW)
