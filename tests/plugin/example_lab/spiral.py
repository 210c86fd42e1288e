"""Spiral: robots go round a centre and come nearer to it."""

import numpy as np

CENTRE = np.array([0.0, 0.0])  # m
K = 0.1  # towards the centre (1/s)
W = 0.4  # around it (rad/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s."""
    x, y = poses[:2, robotNo - 1] - CENTRE
    return -K * x - W * y, W * x - K * y
