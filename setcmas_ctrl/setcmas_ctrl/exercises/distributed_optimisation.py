"""Exercise: distributed optimisation. The robots meet where the sum of private costs is least.

Goal
    Robot i has the cost q_i |p - c_i|^2 / 2, which it alone knows; c_i is its start. All must meet
    where the sum of all costs is least, without telling each other their costs.

Formula to implement
    p_i' = -ALPHA q_i (p_i - c_i) - BETA sum_j a_ij (p_i - p_j) - v_i
    v_i' = ALPHA BETA sum_j a_ij (p_i - p_j), v_i(0) = 0

    so that v_i(k + 1) = v_i(k) + h v_i'(k), with the time h since the previous call. The velocity
    of the robot is p_i'. The position of a robot from which robot i has received nothing is NaN.

What to observe
    1. Leave out v_i first: where do the robots stop, and why not at one point?
    2. With v_i: compare the end with sum q_i c_i / sum q_i.
    3. What does v_i converge to? Print it, and compare with the slope of the robot's cost.

Commands
    setcmas new my_optimisation --from distributed_optimisation --exercise    a copy to edit
    setcmas check my_optimisation                                             checks your solution
    setcmas run --algo my_optimisation --nb-robots 6 --graph ring --duration 60
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'distributed_optimisation'  # selects the tests of setcmas check

Q = [1.0, 2.0, 4.0]  # weights q_i of robots 1, 2, 3, repeated for further robots
ALPHA = 0.2  # gain of the costs (1/s)
BETA = 0.2  # gain of the gaps to neighbours (1/s)

centre = None  # c_i (m): a state; every robot has its own
memory = np.zeros(2)  # v_i at this call (m/s)
rise = np.zeros(2)  # v_i' at the call before (m/s^2)
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the robot's centre and its neighbours."""
    global centre, memory, rise, before
    p = poses[:2, robotNo - 1].copy()
    if centre is None:  # at the first call
        centre, before = p, t
    h, before = t - before, t
    memory = memory + h * rise
    q = Q[(robotNo - 1) % len(Q)]  # q_i
    pull = np.zeros(2)  # sum_j a_ij (p_i - p_j)
    for j in network.neighbours():  # numbers of robots, from 1
        pass  # TODO 1: add p_i - p_j to pull, unless it is NaN
    # TODO 2: store v_i' in rise, and return the velocity
    return 0.0, 0.0
