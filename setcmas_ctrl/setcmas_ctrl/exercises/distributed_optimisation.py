"""Exercise: distributed optimisation. Robots meet where the sum of their private costs is least.

Goal
    Robot i alone knows its cost q_i |p - c_i|^2 / 2, with its start position c_i. Compute its
    velocity from its own cost and the positions of its neighbours, so that all robots meet at the
    minimiser of the sum of all costs.

Formula to implement
    p_i' = -ALPHA q_i (p_i - c_i) - BETA sum_j a_ij (p_i - p_j) - v_i
    v_i' = ALPHA BETA sum_j a_ij (p_i - p_j)

    so that v_i(k + 1) = v_i(k) + h v_i'(k), with the time h from call k to call k + 1, and v_i = 0
    at the first call: keep v_i' until the next call. The position of a robot from which robot i
    has received nothing is NaN.

What to observe
    1. Where do the robots meet? Compare with sum q_i c_i / sum q_i.
    2. Leave out the memory v_i. Where do the robots stop then, and how far apart?
    3. Do they meet at the minimiser in the graph directed_ring, too? Which smaller BETA helps?

Commands
    setcmas check my_optimisation    checks your solution
    setcmas run --algo my_optimisation --nb-robots 6 --graph ring --duration 60
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'distributed_optimisation'  # selects its tests

Q = [1.0, 2.0, 4.0]  # weights q_i of the costs of robots 1, 2, ..., repeated for further robots
ALPHA = 0.2  # gain of the costs (1/s)
BETA = 0.2  # gain of the gaps to neighbours (1/s)

centre = None  # c_i (m)
memory = np.zeros(2)  # v_i (m/s): a state; every robot has its own
rise = np.zeros(2)  # v_i' of the call before (m/s^2)
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the robot's centre and its neighbours."""
    global centre, memory, rise, before
    position = poses[:2, robotNo - 1].copy()  # p_i (m)
    if centre is None:  # at the first call
        centre, before = position, t
    h, before = t - before, t
    memory = memory + h * rise  # v_i of this call
    own_weight = Q[(robotNo - 1) % len(Q)]  # q_i
    weights = network.adjacency()[robotNo - 1]  # a_ij for j = 1 to N
    for j in network.neighbours():  # numbers of robots, from 1
        gap = position - poses[:2, j - 1]  # p_i - p_j (m); NaN if not known
        # TODO 1: sum the terms of the neighbours whose positions are known
    # TODO 2: compute v_i' and keep it in rise; compute the velocity and return it
    return 0.0, 0.0
