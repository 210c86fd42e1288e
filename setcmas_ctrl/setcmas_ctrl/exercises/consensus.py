"""Exercise: consensus. All robots are to meet at the average of their positions.

Goal
    Every robot i has a position p_i = (x_i, y_i) and may choose its velocity v_i. No robot leads.
    Find the velocity of one robot from the positions of all, so that all meet at one point.

Formula to implement
    v_i = -(K/N) sum_j a_ij (p_i - p_j)

    with a_ij = 1 for every other robot j (complete graph) and a_ii = 0.

What to observe
    1. Do the robots meet? Where, compared with the average of their start positions?
    2. Disagreement falls like exp(-K t). Compare K = 0.2, 0.5 and 2 (--set). When does the largest
       speed --vnom hide the difference?
    3. Let every robot hear its successor only (a_ij = 1 for one j). Do they still meet? How fast?

Commands
    setcmas new my_consensus --from consensus --exercise    a copy of this file for you to edit
    setcmas check my_consensus                              what is right, and what is missing
    setcmas run --algo my_consensus --nb-robots 8 --duration 40
    setcmas run --algo my_consensus --nb-robots 8 --duration 40 --set K=2
    setcmas offline --algo my_consensus --nb-robots 8       the same, in a moment
"""

import numpy as np

task = 'consensus'  # what it is measured by, and drawn with
exercise = 'consensus'  # what setcmas check marks it by

K = 0.5  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that leads the robot to the others."""
    positions = poses[:2]  # row 0: x of every robot, row 1: y (m)
    p = positions[:, robotNo - 1]  # of this robot; robots count from 1, columns from 0
    v = np.zeros(2)
    for j in range(nbRobots):
        # TODO: add the part of robot j, whose position is positions[:, j]
        pass
    return v[0], v[1]
