"""Leader election: robots elect a leader by messages, and gather at its start position.

Each robot has a number, and sends the largest that it has received so far (max-consensus):

    m_i(k + 1) = max(m_i(k), max of m_j(k) over the robots j that i receives)
    v_i = K (p - p_i)

with m_i(0) its own number, and p the place that the leader sends with it. The robot with the
largest number leads. After k + 1 calls each robot has the largest number within k links, so in a
strongly connected graph without loss or delay all agree one call after the graph's diameter.
Source: FloodMax in Lynch, Distributed Algorithms, Morgan Kaufmann, 1996, section 4.1.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

K = 0.5  # gain (1/s)
NUMBERS = []  # of robots 1, 2, ...; further robots draw theirs between 0 and 1
SLOW = 0.01  # speed (m/s) below which robots stop

leader = ()  # number, robot and place (m) of the leader, as far as this robot has received


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot towards the leader's place."""
    global leader
    x, y = poses[:2, robotNo - 1]
    if not leader:
        drawn = np.random.default_rng().random()
        leader = (NUMBERS[robotNo - 1] if robotNo <= len(NUMBERS) else drawn, robotNo, x, y)
    for message in network.received().values():
        leader = max(leader, tuple(message.value))
    network.send(leader)
    return dead_band(K * (leader[2] - x), K * (leader[3] - y), SLOW)
