"""Coverage: robots spread over a box, each towards the centroid of its Voronoi cell.

    v_i = K (C_i - p_i)

with the centroid C_i of the points of the box that are nearer to robot i than to the others. The
law descends the gradient of the cost H, the integral over the box of the squared distance to the
nearest robot: H never rises, and robots converge to the centroids of their own cells. On a line of
length 1 these are at (2 k - 1) / (2 N), k = 1, ..., N, reached at the rate K sin^2(pi / (2 N)). A
robot needs the positions of the robots whose cells touch its own; one without a cell, outside the
box, drives into it.
Source: Cortes, Martinez, Karatas and Bullo, Coverage control for mobile sensing networks, IEEE
Transactions on Robotics and Automation 20(2), 2004.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'coverage'  # selects its metrics and plots

K = 0.5  # gain (1/s)
BOX = [[-6, -6], [6, 6]]  # lower left and upper right corner (m)
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the centroid of the robot's cell."""
    place, others = poses[:2, robotNo - 1], poses[:2, [j - 1 for j in network.neighbours()]].T
    corners = cell(place, others[np.isfinite(others[:, 0])])  # those that it has received
    goal = centroid(corners) if len(corners) > 2 else np.clip(place, *BOX)
    return dead_band(*(K * (goal - place)), SLOW)


def cell(place, others):
    """Return the corners of the part of BOX that is nearer to a place than to others, (M, 2)."""
    (left, bottom), (right, top) = BOX
    corners = np.array([[left, bottom], [right, bottom], [right, top], [left, top]], dtype=float)
    for other in others:
        beyond = (corners - (place + other) / 2) @ (other - place)  # above 0: nearer to the other
        if beyond.max(initial=0.0) <= 0:
            continue
        after = following(beyond)
        cut = beyond * after < 0  # sides that the bisector cuts
        crossings = corners.copy()
        sides = (following(corners) - corners)[cut]
        crossings[cut] += (beyond[cut] / (beyond - after)[cut])[:, None] * sides
        keep = np.array([beyond <= 0, cut]).T
        corners = np.array([corners, crossings]).swapaxes(0, 1)[keep]
    return corners


def following(values):
    """Return the values of the next corners."""
    return np.concatenate([values[1:], values[:1]])


def centroid(corners):
    """Return the centroid of a polygon."""
    after = following(corners)
    areas = corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]
    return areas @ (corners + after) / (3 * areas.sum())
