"""Trajectory tracking: each robot follows a point that moves on a circle.

The reference is r(t) = R (cos(W t), sin(W t)), with t counted from the script's first call.
Proportional control with feedforward of the reference's velocity:

    v = KP (r - p) + dr/dt

Source: S. Bertrand, SETCMAS, European Control Conference 2024; feedforward and proportional
tracking as in Siciliano et al., Robotics, 2009, section 11.6.
"""

import numpy as np
import rviz_marker_array

from setcmas_ctrl.saturation import dead_band

task = 'tracking'  # selects its metrics and plots

R = 2.0  # radius of the circle (m)
W = 0.2  # angular rate along the circle (rad/s)
KP = 0.8  # gain (1/s)
SLOW = 0.01  # speed (m/s) below which robots stop

start = None  # time of the first call (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that keeps the robot on the reference."""
    global start
    if start is None:
        start = t
    angle = W * (t - start)
    reference = R * np.array([np.cos(angle), np.sin(angle)])
    reference_velocity = R * W * np.array([-np.sin(angle), np.cos(angle)])
    rviz_marker_array.publish_marker(
        reference[0], reference[1], 0, robotNo, [1, 1, 0], 0.1, 'traj_ref', alpha=0.5
    )
    vx, vy = KP * (reference - poses[:2, robotNo - 1]) + reference_velocity
    return dead_band(vx, vy, SLOW)
