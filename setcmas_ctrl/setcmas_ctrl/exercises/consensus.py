"""Exercise: consensus. All robots meet at the average of their positions.

Goal
    Robot i has the position p_i = (x_i, y_i) and chooses its velocity v_i. No robot leads.
    Compute each robot's velocity from all positions, so that all robots meet at one point.

Formula to implement
    v_i = -(K/N) sum_j a_ij (p_i - p_j)

    with a_ij = 1 for every other robot j (complete graph) and a_ii = 0.

What to observe
    1. Do the robots meet? Is it at the average of their start positions?
    2. The disagreement decays as exp(-K t). Compare K = 0.2, 0.5 and 2. When does the speed
       limit vnom hide the difference?
    3. Let every robot use only its successor (a_ij = 1 for one j). Do they still meet? How fast?

Commands
    setcmas check my_consensus    checks your solution
    setcmas run --algo my_consensus --nb-robots 8 --duration 40
    setcmas run --algo my_consensus --nb-robots 8 --duration 40 --set K=2
    setcmas offline --algo my_consensus --nb-robots 8       the same, without ROS, in a second
"""

import numpy as np

task = 'consensus'  # selects its metrics and plots
exercise = 'consensus'  # selects its tests

K = 0.5  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards the others."""
    positions = poses[:2]  # row 0: x of every robot, row 1: y (m)
    p = positions[:, robotNo - 1]  # this robot's; robots count from 1, columns from 0
    v = np.zeros(2)
    for j in range(nbRobots):
        # TODO: add the term of robot j, whose position is positions[:, j]
        pass
    return v[0], v[1]
