"""Exercise: resilient consensus (W-MSR). Honest robots agree although one disobeys.

Goal
    Robot 1 drives along a circle and ignores the others. With plain consensus it drags the others
    along. Let each honest robot ignore the most extreme values, so that they agree among
    themselves.

Formula to implement
    Robot i sorts the values p_j - p_i of its neighbours, for each coordinate. It ignores the F
    largest of those above 0 and the F smallest of those below 0 (all, if there are fewer). With
    the remaining neighbours N_i, those with the value 0 included:

    v_i = K / (1 + |N_i|) sum over j in N_i of (p_j - p_i)

What to observe
    1. Set F = 0: where does the rebel take the others?
    2. Do honest robots leave the interval of their starts? See honest.largest_exit_m.
    3. In the graph ring it fails: two arcs of equal values never meet. How robust is a ring?

Commands
    setcmas check my_resilience    checks your solution
    setcmas run --algo my_resilience --nb-robots 8 --duration 60
"""

import numpy as np

from setcmas_ctrl import network

task = 'resilience'  # selects its metrics and plots
exercise = 'resilient_consensus'  # selects its tests

K = 0.5  # gain (1/s)
F = 1  # robots that may not follow the law
REBELS = [1]  # robots that do not: they drive along a circle

RADIUS = 3.0  # of the circle (m)
W = 0.1  # angular rate along it (rad/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of an honest robot or of a rebel."""
    if robotNo in REBELS:
        # TODO 1: remove this line, once the honest robots have their law
        return 0.0, 0.0
        return -RADIUS * W * np.sin(W * t), RADIUS * W * np.cos(W * t)
    others = [j - 1 for j in network.neighbours()]
    gaps = poses[:2, others] - poses[:2, robotNo - 1, None]  # p_j - p_i: row 0 x, row 1 y (m)
    return component(gaps[0]), component(gaps[1])


def component(gaps):
    """Return one component of the velocity, in m/s, from those of all p_j - p_i in m."""
    above, below = np.sort(gaps[gaps > 0]), np.sort(gaps[gaps < 0])  # from small to large
    # TODO 2: ignore the F largest above 0 and the F smallest below 0, and return the component
    return 0.0
