"""Consensus by the Laplacian, v = -K L p: the law of the theory, without dead band."""

import numpy as np

from setcmas_ctrl import network

task = 'consensus'

K = 0.1  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards those that the robot hears."""
    weights = network.adjacency()[robotNo - 1]
    gaps = poses[:2] - poses[:2, robotNo - 1, None]
    gaps[np.isnan(gaps)] = 0.0  # of robots that it does not hear
    vx, vy = K * gaps @ weights
    return vx, vy
