"""Exercise: dynamic average consensus. Robots follow the mean of targets that move.

Goal
    Each robot has a moving target of its own, which no other robot knows. Robots send estimates
    of the mean of all targets. Compute the estimate, and the velocity that follows it.

Formula to implement
    x_i(k + 1) = x_i(k) + h x_i'(k), x_i' = r_i' - K sum_j a_ij (x_i - x_j), x_i(0) = r_i(0)
    v_i = KP (x_i - p_i) + x_i'

    with the target r_i, its velocity r_i', and the time h since the previous call (0 at the
    first). x_i in v_i is the new estimate; send it at each call, as an array of two numbers. x_j
    is the value received from robot j.

What to observe
    1. How far do estimates stay from their mean in the graphs path, ring and complete? In theory
       pinv(K L) Pi r' with Pi r' = r' - mean(r'), roughly proportional to 1/lambda_2.
    2. Leave out r_i' in x_i'. How well do robots follow the mean then?
    3. Lose a tenth of the messages: why does the error remain after the losses end?

Commands
    setcmas check my_average    checks your solution
    setcmas run --algo my_average --nb-robots 6 --graph ring --duration 40
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'dynamic_average'  # selects its tests

K = 0.5  # gain of the estimates (1/s)
KP = 0.8  # gain of the position (1/s)
DRIFTS = [[0.1, 0.0], [0.0, 0.1], [0.1, 0.1]]  # velocities of targets 1, 2, ..., repeated (m/s)

estimate = None  # x_i (m): a state; every robot has its own
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot with its estimate of the mean."""
    global estimate, before
    position = poses[:2, robotNo - 1].copy()  # p_i (m)
    if before is None:  # at the first call: the target starts where the robot does
        estimate, before = position, t
    h, before = t - before, t
    drift = np.array(DRIFTS[(robotNo - 1) % len(DRIFTS)])  # r_i' (m/s)
    weights = network.adjacency()[robotNo - 1]  # a_ij for j = 1 to N
    for j, message in network.received().items():  # j: number of the sender, from 1
        other = message.value  # x_j (m)
        # TODO 1: sum the terms of the robots from which this robot has received
    # TODO 2: compute the new estimate, send it with network.send, and return the velocity
    return 0.0, 0.0
