"""Exercise: dynamic average consensus. The robots follow the mean of moving targets.

Goal
    Each robot sees one target, which moves. Robots send their estimates of the mean of all
    targets. Compute the estimate of each robot, so that all follow the mean.

Formula to implement
    x_i(k + 1) = x_i(k) - h K sum_j a_ij (x_i(k) - x_j(k)) + r_i(k + 1) - r_i(k), x_i(0) = r_i(0)

    with the target r_i and the time h since the previous call (0 at the first). x_i is sent at each
    call, and x_j(k) is the value received from robot j. Once the estimates are right, the robots
    drive with v_i = KP (x_i - p_i) + x_i', which is given.

What to observe
    1. Leave out r_i(k + 1) - r_i(k): how far behind the mean do the robots drive?
    2. How far apart do the robots drive in --graph ring and --graph complete? Compare with
       pinv(K L) Pi r' of `setcmas metrics`.
    3. With --loss 0.2: why does an error remain for ever?

Commands
    setcmas new my_average --from dynamic_average --exercise    a copy of this file to edit
    setcmas check my_average                                    checks your solution
    setcmas run --algo my_average --nb-robots 5 --graph ring --duration 60
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'dynamic_average'  # selects the tests of setcmas check

K = 0.5  # gain of the estimates (1/s)
KP = 0.8  # gain of the position (1/s)
DRIFTS = [[0.1, 0.0], [0.0, 0.1], [0.1, 0.1]]  # velocities of targets 1, 2, 3, repeated (m/s)

target = estimate = None  # r_i and x_i (m): states; every robot has its own
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot with its estimate of the mean."""
    global target, estimate, before
    p = poses[:2, robotNo - 1].copy()  # this robot's position (m)
    if target is None:  # at the first call
        target, estimate, before = p, p, t
    h, before = t - before, t
    drift = np.array(DRIFTS[(robotNo - 1) % len(DRIFTS)])  # r_i' (m/s)
    weights = network.adjacency()[robotNo - 1]  # a_ij for j = 1 to N
    new_target = target + h * drift  # r_i(k + 1)
    new_estimate = None  # TODO 1: compute x_i(k + 1); message.value is x_j(k)
    for j, message in network.received().items():  # j: number of the sender, from 1
        pass
    # TODO 2: send the new estimate with network.send
    if new_estimate is None:
        return 0.0, 0.0
    rate = (new_estimate - estimate) / h if h > 0 else np.zeros(2)  # x_i' (m/s)
    target, estimate = new_target, new_estimate
    v = KP * (estimate - p) + rate
    return v[0], v[1]
