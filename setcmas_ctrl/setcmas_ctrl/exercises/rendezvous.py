"""Exercise: rendezvous with a sensing range. No link between robots breaks while they meet.

Goal
    A robot sees only the robots within the range D. With equal weights a link may break while the
    robots move. Let the weight of a link grow as its length comes near D, so that none breaks.

Formula to implement
    v_i = -K sum_j (2 D - l_ij) / (D - l_ij)^2 (p_i - p_j) over the robots j within D

    with the length l_ij = |p_i - p_j|. Take min(l_ij, MARGIN D) for the length in the weight, so
    that it stays finite. The position of a robot from which robot i has received nothing is NaN.

What to observe
    1. Compare the links at the start and at the end (metrics: broken links), with your
       law and with the weight 1.
    2. How large is the weight for l = 0, D/2 and 0.99 D?
    3. Why may a link break nevertheless when the law is called only every 0.5 s (a rate of 2 Hz)?

Commands
    setcmas check my_rendezvous    checks your solution
    setcmas run --algo my_rendezvous --nb-robots 8 --range 6 --duration 40
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'rendezvous'  # selects its tests

K = 0.1  # gain (m/s)
D = 6.0  # range (m), as that of the run
MARGIN = 0.999  # of D, beyond which the weight does not grow any more


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the robots in range."""
    v = np.zeros(2)
    for j in network.neighbours():  # numbers of the robots within D, from 1
        gap = poses[:2, robotNo - 1] - poses[:2, j - 1]  # p_i - p_j (m); NaN if not known
        # TODO: compute the length of the link and its weight, and add the term unless it is NaN
    return v[0], v[1]
