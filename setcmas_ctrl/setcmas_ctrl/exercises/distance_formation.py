"""Exercise: distance formation. Robots keep the distances of a shape to their neighbours.

Goal
    The shape has the points P_1 to P_N. Compute each robot's velocity from its neighbours'
    positions, so that the robots form the shape; it may be anywhere, turned or mirrored.

Formula to implement
    v_i = -K sum_j a_ij (|p_i - p_j|^2 - |P_i - P_j|^2) (p_i - p_j)

    with the weights a_ij of the graph. The position of a robot from which robot i has received
    nothing is NaN.

What to observe
    1. What is the unit of K? Which distance errors remain after 30 s?
    2. Where is the centre of the robots at the start and at the end? Why?
    3. Does --graph ring keep the shape of five robots? Count its links: a rigid graph in the
       plane needs 2 N - 3.

Commands
    setcmas new my_distances --from distance_formation --exercise    a copy of this file to edit
    setcmas check my_distances                                       checks your solution
    setcmas run --algo my_distances --nb-robots 5 --random-poses box=6x6,distance=1 --duration 30
"""

import numpy as np

from setcmas_ctrl import network

exercise = 'distance_formation'  # selects the tests of setcmas check

K = 0.02  # gain (1/(m^2 s))
P = None  # points of the shape (m); by default a regular polygon with a radius of 2 m


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that corrects the distances to neighbours."""
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
    return 2 * np.column_stack([np.cos(angles), np.sin(angles)]) if P is None else np.array(P)
