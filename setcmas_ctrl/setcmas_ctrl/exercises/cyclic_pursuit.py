"""Exercise: cyclic pursuit. Each robot pursues the next, at an angle.

Goal
    Robot i pursues robot i + 1, the last robot pursues robot 1. Compute the velocities, so that
    the robots end on a circle, equally spaced, and drive along it.

Formula to implement
    v_i = K R(alpha) (p_(i+1) - p_i), with p_(N+1) = p_1

    R(alpha) = [cos alpha, -sin alpha; sin alpha, cos alpha] turns to the left by alpha, which is
    ALPHA, or pi/N if ALPHA is None.

What to observe
    1. Predict the angular rate on the circle, 2 K sin(pi/N), for five robots. Measure it.
    2. Where do the robots go with --set ALPHA=0? And with an angle between pi/N and 2 pi/N?
    3. The robots have a --rate. With --set K=1 the circle grows. Why?

Commands
    setcmas new my_pursuit --from cyclic_pursuit --exercise    a copy of this file to edit
    setcmas check my_pursuit                                   checks your solution
    setcmas run --algo my_pursuit --nb-robots 5 --random-poses auto --duration 60
"""

import numpy as np

exercise = 'cyclic_pursuit'  # selects the tests of setcmas check

K = 0.05  # gain (1/s)
ALPHA = None  # angle (rad); None: pi/N


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of the pursuit of the next robot."""
    positions = poses[:2]  # row 0: x of every robot, row 1: y (m)
    alpha = np.pi / nbRobots if ALPHA is None else ALPHA
    p = positions[:, robotNo - 1]  # this robot's; robots count from 1, columns from 0
    # TODO: find the next robot, and turn the vector to it by alpha
    return 0.0, 0.0
