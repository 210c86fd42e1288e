"""Exercise: containment. Followers move into the convex hull of leaders that stand still.

Goal
    Robots 1 to 3 are leaders and stand still. Each follower knows only its neighbours. Compute the
    velocities of the followers, so that they end up in the triangle of the leaders.

Formula to implement
    v_i = -K sum_j a_ij (p_i - p_j) for followers, v_i = 0 for leaders

    with the weights a_ij of the graph. The position of a robot from which robot i has received
    nothing is NaN.

What to observe
    1. Where do the followers end up in the graph ring? Compute -inv(L_FF) L_FL p_L (8 robots).
    2. Which rate do the metrics predict, and which eigenvalue is it?
    3. With one leader (LEADERS = [1]) where do all robots meet? And without leaders?

Commands
    setcmas check my_containment    checks your solution
    setcmas run --algo my_containment --nb-robots 8 --graph ring --duration 60
"""

import numpy as np

from setcmas_ctrl import network

exercise = 'containment'  # selects its tests

K = 0.3  # gain (1/s)
LEADERS = [1, 2, 3]  # robots that stand still


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of a leader or of a follower."""
    positions = poses[:2]  # row 0: x of every robot, row 1: y (m); NaN if not known
    weights = network.adjacency()[robotNo - 1]  # a_ij of this robot, for j = 1 to N
    v = np.zeros(2)
    # TODO: if this robot is a follower, add the terms of the neighbours whose positions are known
    return v[0], v[1]
