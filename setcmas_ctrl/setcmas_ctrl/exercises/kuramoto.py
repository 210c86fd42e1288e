"""Exercise: Kuramoto oscillators. Robots that circle at different rates fall into step.

Goal
    Each robot drives in the direction of a phase, which turns at a rate of its own. Robots send
    their phases. Couple them, so that all turn at the same rate.

Formula to implement
    theta_i' = w_i + K/N sum_j a_ij sin(theta_j - theta_i), v_i = SPEED (cos theta_i, sin theta_i)

    so that theta_i(k + 1) = theta_i(k) + h theta_i'(k), with the time h since the previous call
    (0 at the first). theta_i begins as the heading of the robot, which sends it at each call.

What to observe
    1. With two robots: from what K on do they fall into step? Compare with DW.
    2. Which lag remains between them? In theory asin(DW / K).
    3. Eight robots with DW = 0: are all phases equal at the end, from every start?

Commands
    setcmas check my_kuramoto    checks your solution
    setcmas run --algo my_kuramoto --nb-robots 6 --duration 60 --random-poses auto
"""

import numpy as np

from setcmas_ctrl import network

task = 'alignment'  # selects its metrics and plots
exercise = 'kuramoto'  # selects its tests

K = 0.3  # coupling (1/s)
W = 0.2  # mean rate of the robots (rad/s)
DW = 0.1  # difference between the rates of the last and the first robot (rad/s)
SPEED = 0.2  # m/s

phase = None  # theta_i (rad): a state; every robot has its own
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s in the direction of the phase."""
    global phase, before
    if before is None:  # at the first call
        phase, before = poses[2, robotNo - 1], t
    h, before = t - before, t
    own_rate = np.linspace(W - DW / 2, W + DW / 2, nbRobots)[robotNo - 1]  # w_i (rad/s)
    for j, message in network.received().items():  # j: number of the sender, from 1
        other = message.value  # theta_j (rad)
        # TODO 1: sum the terms of the robots from which this robot has received
    # TODO 2: compute the new phase, send it with network.send, and return the velocity
    return 0.0, 0.0
