"""Exercise: coverage. The robots spread over a box, each towards the centroid of its cell.

Goal
    The cell of a robot holds the points of the box that are nearer to it than to any other robot.
    Let each robot drive to the centroid of its cell, which you approximate with a grid of points.

Formula to implement
    v_i = K (C_i - p_i)

    where C_i is the mean of the grid points that are nearer to robot i than to the others; without
    such a point, v_i = 0. The position of a robot from which robot i has received nothing is NaN.

What to observe
    1. Does the cost (see the metrics) ever rise? Where do four robots end?
    2. Start several times at random (other seeds): is the end always the same?
    3. What happens with a range of 3 m, where cells overlap?

Commands
    setcmas check my_coverage    checks your solution
    setcmas run --algo my_coverage --nb-robots 8 --duration 60 --random-poses box=4x4,distance=0.8
"""

import numpy as np

task = 'coverage'  # selects its metrics and plots
exercise = 'coverage'  # selects its tests

K = 0.5  # gain (1/s)
BOX = [[-6, -6], [6, 6]]  # lower left and upper right corner (m)
step = 0.125  # between two grid points (m)


def grid():
    """Return points of the box in m, shape (M, 2)."""
    (left, bottom), (right, top) = BOX
    x, y = np.arange(left + step / 2, right, step), np.arange(bottom + step / 2, top, step)
    return np.array([(a, b) for a in x for b in y])


points = grid()


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the centroid of the robot's cell."""
    p = poses[:2, robotNo - 1]  # this robot's position (m)
    to_own = np.linalg.norm(points - p, axis=1)  # distances of all points (m)
    # TODO 1: find the points that are nearer to this robot than to each other robot
    # TODO 2: return K times the vector to their mean
    return 0.0, 0.0
