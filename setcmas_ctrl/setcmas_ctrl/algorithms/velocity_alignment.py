"""Velocity alignment: robots agree on a velocity by messages, and drive with it.

    w_i(k + 1) = w_i(k) + h K sum_j a_ij (w_j(k) - w_i(k)), v_i = w_i

with the time h between two calls: w' = -K L w. Robots send w_i. In an undirected connected graph
their mean stays, and all converge to it at the rate K lambda_2, wherever the robots are. At the
start the directions of robots 1 to N are evenly spread.
Source: Jadbabaie, Lin and Morse, Coordination of groups of mobile autonomous agents using nearest
neighbor rules, IEEE Transactions on Automatic Control 48(6), 2003; the alignment of Olfati-Saber,
Flocking for multi-agent dynamic systems: algorithms and theory, the same journal 51(3), 2006.
"""

import numpy as np

from setcmas_ctrl import network

task = 'alignment'  # selects its metrics and plots

K = 0.3  # gain (1/s)
SPEED = 0.2  # at the start (m/s)
SPREAD = 3.0  # angle between the directions of the first and the last robot at the start (rad)
WAIT = 2.0  # time (s) after which a robot that receives nothing stands still

velocity = None  # its own (m/s)
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the new velocity (vx, vy) in m/s of the robot."""
    global velocity, before
    if before is None:
        velocity, before = starts(nbRobots)[:, robotNo - 1], t
    weights, received = network.adjacency()[robotNo - 1], network.received()
    gaps = [weights[j - 1] * (message.value - velocity) for j, message in received.items()]
    velocity, before = velocity + (t - before) * K * sum(gaps), t
    network.send(velocity)
    return velocity if received or (t < WAIT and network.neighbours()) else (0.0, 0.0)


def starts(count):
    """Return the velocities at the start: rows vx and vy in m/s, shape (2, count)."""
    angles = np.linspace(-SPREAD / 2, SPREAD / 2, count)
    return SPEED * np.array([np.cos(angles), np.sin(angles)])
