"""Exercise: cyclic pursuit. Each robot pursues the next, and all end on a circle.

Goal
    Robot i pursues robot i + 1, the last robot pursues robot 1. Robots that head straight
    for the next end up at one point; at an angle to this direction, on a circle.

Formula to implement
    v_i = K R(ALPHA) (p_(i+1) - p_i), R(ALPHA) = [cos ALPHA, -sin ALPHA; sin ALPHA, cos ALPHA]

    with ALPHA = pi/N. The position of a robot from which robot i has received nothing is NaN; then
    robot i stands still.

What to observe
    1. On which circle do five robots end up, and how fast do they drive along it? In theory at
       2 K sin(pi/N) rad/s.
    2. What happens for ALPHA = 0, and for ALPHA = 1.2 pi/N?
    3. Does it work in the graph directed_ring? And in a graph file with the opposite directions?

Commands
    setcmas check my_pursuit    checks your solution
    setcmas run --algo my_pursuit --nb-robots 5 --duration 60
"""

import numpy as np

exercise = 'cyclic_pursuit'  # selects its tests

K = 0.05  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of the pursuit of the next robot."""
    p = poses[:2, robotNo - 1]  # this robot's position (m); columns count from 0
    ALPHA = np.pi / nbRobots
    # TODO 1: find the position of the robot that this one pursues
    # TODO 2: turn the vector to it by ALPHA, and return K times it
    return 0.0, 0.0
