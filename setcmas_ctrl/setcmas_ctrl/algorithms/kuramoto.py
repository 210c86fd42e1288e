"""Kuramoto oscillators: robots that circle at different rates fall into step.

Each robot keeps a phase theta_i, at first its heading, sends it, and drives in its direction:

    theta_i' = w_i + K/N sum_j a_ij sin(theta_j - theta_i), v_i = SPEED (cos theta_i, sin theta_i)

with rates w_i evenly from W - DW/2 (robot 1) to W + DW/2 (robot N). Two robots lock if and only
if DW <= K, with the lag asin(DW/K). More robots lock in an undirected connected graph if
pinv(K L/N) w differs by less than 1 along each link: exact for trees, nearly so for others. With
DW = 0 the phases of the complete graph converge at the rate K; otherwise theta_i is ahead of the
mean phase by asin((w_i - W)/(K r)), with the mean r of the cosines of these lags.
Source: Sepulchre, Paley and Leonard, Stabilization of planar collective motion: all-to-all
communication, IEEE Transactions on Automatic Control 52(5), 2007; the condition: Doerfler,
Chertkov and Bullo, Synchronization in complex oscillator networks and smart grids, PNAS, 2013.
"""

import numpy as np

from setcmas_ctrl import network

task = 'alignment'  # selects its metrics and plots

K = 0.3  # coupling (1/s)
W = 0.2  # mean rate of the robots (rad/s)
DW = 0.1  # difference between the rates of the last and the first robot (rad/s)
SPEED = 0.2  # m/s
WAIT = 2.0  # time (s) after which a robot that receives nothing stands still

phase = None  # its own (rad)
before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s in the direction of the phase."""
    global phase, before
    if before is None:
        phase, before = poses[2, robotNo - 1], t
    weights, received = network.adjacency()[robotNo - 1], network.received()
    pulls = [weights[j - 1] * np.sin(message.value - phase) for j, message in received.items()]
    rate = np.linspace(W - DW / 2, W + DW / 2, nbRobots)[robotNo - 1] + K / nbRobots * sum(pulls)
    phase, before = phase + (t - before) * rate, t
    network.send(phase)
    speed = SPEED if received or (t < WAIT and network.neighbours()) else 0.0
    return speed * np.cos(phase), speed * np.sin(phase)
