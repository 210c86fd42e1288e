"""Exercise: bearing formation. The directions of links determine a shape.

Goal
    The shape has the points P_1 to P_N. Compute each robot's velocity, so that the line from a
    robot to each neighbour gets the direction it has in the shape. Size and place are free.

Formula to implement
    v_i = -K sum_j a_ij (I - g_ij g_ij') (p_i - p_j),    g_ij = (P_i - P_j) / |P_i - P_j|

    with the weights a_ij of the graph and the 2 x 2 identity I. The position of a robot from which
    robot i has received nothing is NaN.

What to observe
    1. Which size has the shape at the end? Compare with the formula of the built-in law.
    2. What does I - g g' do with a vector along g, and with a vector across it?
    3. Start the robots on the shape turned by 180 degrees (--poses). Do they move?

Commands
    setcmas new my_bearings --from bearing_formation --exercise    a copy of this file to edit
    setcmas check my_bearings                                      checks your solution
    setcmas run --algo my_bearings --nb-robots 5 --random-poses auto --duration 60
"""

import numpy as np

from setcmas_ctrl import network

exercise = 'bearing_formation'  # selects the tests of setcmas check

K = 0.2  # gain (1/s)
P = None  # points of the shape (m); by default a regular polygon


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that corrects the directions to neighbours."""
    points = shape(nbRobots)  # row i - 1: P_i (m)
    p = poses[:2, robotNo - 1]  # p_i (m)
    weights = network.adjacency()[robotNo - 1]  # a_ij of this robot, for j = 1 to N
    v = np.zeros(2)
    for j in network.neighbours():  # numbers of robots, from 1
        q = poses[:2, j - 1]  # p_j (m); NaN if not known
        # TODO: if q is known, add the term of robot j
    return v[0], v[1]


def shape(nbRobots):
    """Return the points of the shape in m, shape (N, 2)."""
    angles = -2 * np.pi * np.arange(nbRobots) / nbRobots
    return np.column_stack([np.cos(angles), np.sin(angles)]) if P is None else np.array(P)
