"""Exercise: finite-time consensus. The robots meet by a time that you compute in advance.

Goal
    With v_i = -K sum_j a_ij (p_i - p_j) robots get ever closer, but never meet. Replace each
    difference by a power of it, so that they meet after a finite time.

Formula to implement
    v_i = K sum_j a_ij sig(p_j - p_i)^ALPHA

    with sig(x)^ALPHA = sign(x) |x|^ALPHA for each coordinate. The position of a robot from which
    robot i has received nothing is NaN.

What to observe
    1. Plot the disagreement: on a logarithmic scale, is it still a straight line?
    2. How does the settling time change with ALPHA (ALPHA = 0.8 in the graph ring)?
    3. Why do robots oscillate at the end? Compare rates of 5 and 50 Hz.

Commands
    setcmas check my_finite_time    checks your solution
    setcmas run --algo my_finite_time --nb-robots 6 --graph ring --duration 40
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'finite_time_consensus'  # selects its tests

K = 0.2  # gain (m^(1 - ALPHA)/s)
ALPHA = 0.5  # exponent


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards its neighbours."""
    v = np.zeros(2)
    for j in network.neighbours():  # numbers of robots, from 1
        gap = poses[:2, j - 1] - poses[:2, robotNo - 1]  # p_j - p_i (m); NaN if not known
        # TODO: add K sig(gap)^ALPHA for each coordinate, unless gap is NaN
    return v[0], v[1]
