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
from setcmas_ctrl.control.prediction import LinearLaw, Predicted
from setcmas_ctrl.control.saturation import dead_band

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


def doubts(conditions):
    """Yield why robots may elect several leaders, or miss the place."""
    count = len(conditions.adjacency)
    if 0 < len(NUMBERS) < count:
        yield f'NUMBERS has {len(NUMBERS)} of {count} numbers: other robots draw theirs'
    if not network.reachable(conditions.adjacency).all():
        yield 'the graph is not strongly connected: robots may elect several leaders'
    yield from LinearLaw(K * np.eye(1), 'K').doubts(conditions.period, meet=False)


def predict(conditions):
    """Return a bound of the time of agreement, if every state is sent and arrives at once."""
    links = (conditions.adjacency > 0) + np.eye(len(conditions.adjacency))
    if conditions.delay or conditions.threshold or not network.reachable(links).all():
        return {}
    reached, diameter = np.eye(len(links)), 0
    while not reached.all():
        reached, diameter = np.minimum(reached @ links, 1.0), diameter + 1
    bound = Predicted(diameter * conditions.period, 'the upper bound h times the diameter')
    return {'messages.agreement_time_s': bound}
