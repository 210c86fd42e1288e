"""Exercise: second-order consensus. Robots with inertia meet if their velocities are damped.

Goal
    The law chooses accelerations: the velocity is their integral. Robots send their velocities.
    Compute the acceleration of each robot, so that all meet and stop.

Formula to implement
    v_i' = -sum_j a_ij (K (p_i - p_j) + G (v_i - v_j))

    so that v_i(k + 1) = v_i(k) + h v_i'(k), with the time h since the previous call (0 at the
    first) and v_i = 0 at the start. v_i is sent at each call; take v_j = 0 until a message
    of robot j arrives. The position of a robot from which robot i has received nothing is NaN.

What to observe
    1. Compare G = 0, 0.2 and 0.8 in the graph ring: when do the robots oscillate?
    2. In directed_ring G must exceed a bound. Compute it for five robots; try both sides.
    3. Where do they meet? Why is this the mean of their starts in the graph ring?

Commands
    setcmas check my_second_order    checks your solution
    setcmas run --algo my_second_order --nb-robots 5 --graph ring --duration 60
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'second_order_consensus'  # selects its tests

K = 0.1  # gain of positions (1/s^2)
G = 0.4  # gain of velocities (1/s)

velocity = np.zeros(2)  # v_i (m/s): a state; every robot has its own
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s, the integral of the acceleration."""
    global velocity, before
    h, before = t - (t if before is None else before), t
    received = network.received()  # {sender: message}; message.value is v_j (m/s)
    for j in network.neighbours():  # numbers of robots, from 1
        gap = poses[:2, robotNo - 1] - poses[:2, j - 1]  # p_i - p_j (m); NaN if not known
        # TODO 1: sum up the acceleration from the terms of all neighbours
    # TODO 2: compute the new velocity, send it with network.send, and return it
    return 0.0, 0.0
