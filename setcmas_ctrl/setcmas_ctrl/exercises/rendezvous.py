"""Exercise: rendezvous with a limited range. Robots meet without losing a link.

Goal
    Robots receive from those within the range D only. Compute each robot's velocity, so that all
    meet and no link that exists at the start is ever lost.

Formula to implement
    v_i = -K sum_j (2 D - l_ij) / (D - l_ij)^2 (p_i - p_j) over the neighbours j

    with the length l_ij = |p_i - p_j|. In the weight use min(l_ij, MARGIN D), so that it stays
    finite. Then reduce the speed to at most (D - l)/(2 h), where l is the longest l_ij below D,
    and h the time since the call before. At the first call stand still.

What to observe
    1. When does the weight of a link grow without bound? What does that prevent?
    2. Compare with --algo laplacian_consensus --range 6 from the same places: count broken links.
    3. Set MARGIN to 0.5. Do the robots still meet? Are links lost?

Commands
    setcmas new my_rendezvous --from rendezvous --exercise    a copy of this file to edit
    setcmas check my_rendezvous                               checks your solution
    setcmas run --algo my_rendezvous --nb-robots 6 --range 6 --duration 40
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'rendezvous'  # selects the tests of setcmas check

K = 0.1  # gain (m/s)
D = 6.0  # range (m), that of --range
MARGIN = 0.999  # of D, beyond which the weight does not grow any more

before = None  # time of the call before (s): a state; every robot has its own


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the robots in range."""
    global before
    h, before = 0.0 if before is None else t - before, t
    p = poses[:2, robotNo - 1]  # p_i (m)
    v = np.zeros(2)
    for j in network.neighbours():  # numbers of robots, from 1
        gap = p - poses[:2, j - 1]  # p_i - p_j (m)
        # TODO 1: add the term of robot j
    # TODO 2: reduce the speed; return 0, 0 at the first call, when h is 0
    return v[0], v[1]
