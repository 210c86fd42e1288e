"""Exercise: Laplacian consensus. The graph determines where and how fast the robots meet.

Goal
    A robot knows only the robots from which it receives, its neighbours in the graph. Compute each
    robot's velocity so that all of them meet.

Formula to implement
    v_i = -K sum_j a_ij (p_i - p_j)

    with the weights a_ij of the graph: row i of the adjacency matrix A. The position of a robot
    from which robot i has received nothing is NaN.

What to observe
    1. Compute the Laplacian L = D - A of a path of four robots and its eigenvalues. The
       disagreement decays as exp(-K lambda_2 t). Compare with the metrics.
    2. Compare the graphs path, ring, star and complete: how large is lambda_2 of each?
    3. Put a directed path 1 -> 2 -> 3 -> 4 in a graph file: where do the robots meet now?

Commands
    setcmas check my_laplacian    checks your solution
    setcmas run --algo my_laplacian --nb-robots 4 --graph path --duration 40
    setcmas metrics DIR                                               measured and predicted rate
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'laplacian_consensus'  # selects its tests

K = 0.2  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards its neighbours."""
    positions = poses[:2]  # row 0: x of every robot, row 1: y (m); NaN if not known
    weights = network.adjacency()[robotNo - 1]  # a_ij of this robot, for j = 1 to N
    v = np.zeros(2)
    for j in range(nbRobots):
        # TODO: if robot j is a neighbour (weights[j] > 0) that is known, add its term
        pass
    return v[0], v[1]
