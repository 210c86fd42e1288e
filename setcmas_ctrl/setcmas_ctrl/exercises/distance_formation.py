"""Exercise: distance formation. Robots form a shape from the distances to their neighbours.

Goal
    Each robot knows the distances that it must have to its neighbours, but no directions and
    no places. Compute its velocity from the errors of the squared distances.

Formula to implement
    v_i = -K sum_j a_ij (|p_i - p_j|^2 - |P_i - P_j|^2) (p_i - p_j)

    with the points P of the shape. The position of a robot from which robot i has received nothing
    is NaN.

What to observe
    1. Which shape do five robots form, where, and how is it turned? Does their centre move?
    2. Four robots in the graph ring: which shapes with the right sides are possible? Which graph
       is rigid?
    3. Try random starts: when is a part of the shape mirrored?

Commands
    setcmas check my_distances    checks your solution
    setcmas run --algo my_distances --nb-robots 5 --duration 40
"""

import numpy as np

from setcmas_ctrl import network

exercise = 'distance_formation'  # selects its tests
task = 'distances'  # selects its metrics and plots

K = 0.02  # gain (1/(m^2 s))


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that corrects the distances to neighbours."""
    points = shape(nbRobots)  # P: point i is points[i - 1], [x, y] (m)
    v = np.zeros(2)
    for j in network.neighbours():  # numbers of robots, from 1
        gap = poses[:2, robotNo - 1] - poses[:2, j - 1]  # p_i - p_j (m); NaN if not known
        # TODO: compute the error of the squared distance, and add the term unless gap is NaN
    return v[0], v[1]


def shape(nbRobots):
    """Return the points of a regular polygon with a radius of 2 m, shape (N, 2)."""
    angles = -2 * np.pi * np.arange(nbRobots) / nbRobots
    return 2 * np.column_stack([np.cos(angles), np.sin(angles)])


def references(nbRobots):
    """Return the shape, whose distances the metrics compare with those of the robots."""
    return {'D': shape(nbRobots).tolist()}
