"""Exercise: bearing formation. The directions of links determine a shape, not its size.

Goal
    Each robot knows in which direction each neighbour must be. Compute its velocity from the part
    of p_i - p_j that is across this direction.

Formula to implement
    v_i = -K sum_j a_ij (I - g_ij g_ij') (p_i - p_j), g_ij = (P_i - P_j) / |P_i - P_j|

    with the points P of the shape. The position of a robot from which robot i has received nothing
    is NaN.

What to observe
    1. How large is the shape at the end, and where is its centre? Try other starts.
    2. Robots start in the mirror image of the shape: what happens to its scale?
    3. Four robots in the graph ring: is a square determined by the bearings of its sides?

Commands
    setcmas check my_bearings    checks your solution
    setcmas run --algo my_bearings --nb-robots 5 --duration 40 --random-poses auto
"""

import numpy as np

from setcmas_ctrl import network

exercise = 'bearing_formation'  # selects its tests

K = 0.2  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that corrects the directions to neighbours."""
    angles = -2 * np.pi * np.arange(nbRobots) / nbRobots
    points = np.column_stack([np.cos(angles), np.sin(angles)])  # P: point i is points[i - 1]
    v = np.zeros(2)
    for j in network.neighbours():  # numbers of robots, from 1
        gap = poses[:2, robotNo - 1] - poses[:2, j - 1]  # p_i - p_j (m); NaN if not known
        # TODO 1: compute the unit vector g_ij from points
        # TODO 2: add the term of robot j, unless gap is NaN
    return v[0], v[1]
