"""Exercise: leader election. The robots elect a leader by messages, and gather at its place.

Goal
    Each robot has a number. All must find the largest number and the place of its robot, although
    each robot receives messages from its neighbours only.

Formula to implement
    m_i(k + 1) = max(m_i(k), max of m_j(k) over the robots j that i receives)

    with m_i = (number, robot, x, y), which Python compares by the number first. At the start m_i
    is the robot's own. Each robot sends m_i at each call, and drives to the place in it:

    v_i = K ((x, y) - p_i)

What to observe
    1. After how many calls do all agree (metrics: agreement time)? Compare the graphs path,
       ring and complete with the diameter of the graph.
    2. What happens with a loss of 0.5, and with a delay of 1 s?
    3. Put a directed path in a graph file: which leaders do the first and the last robot have?

Commands
    setcmas check my_election    checks your solution
    setcmas run --algo my_election --nb-robots 6 --graph path --duration 20
"""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'  # selects its metrics and plots
exercise = 'leader_election'  # selects its tests

K = 0.5  # gain (1/s)
NUMBERS = [0.3, 0.1, 0.7, 0.2, 0.9, 0.4]  # of robots 1 to 6; a larger fleet needs more

leader = ()  # m_i: number, robot, x and y (m): a state; every robot has its own


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards the leader's place."""
    global leader
    x, y = poses[:2, robotNo - 1]
    if not leader:  # at the first call
        leader = (NUMBERS[robotNo - 1], robotNo, x, y)
    for message in network.received().values():
        other = tuple(message.value)  # m_j of a robot that this one receives
        # TODO 1: keep the larger of m_i and m_j
    # TODO 2: send m_i with network.send, and return the velocity
    return 0.0, 0.0
