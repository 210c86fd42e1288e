"""Exercise: trajectory tracking. Each robot follows a point that moves on a circle.

Goal
    The reference r(t) = R (cos(W t), sin(W t)) moves. Keep the robot's position p on it:
    with proportional control alone, the robot always lags behind.

Formulas to implement
    r(t) = R (cos(W t), sin(W t))                           (TODO 1)
    dr/dt, first on paper (a difference quotient will do)   (TODO 2)
    v = KP (r - p) + dr/dt                                  (TODO 3)

What to observe
    1. Run with v = KP (r - p) alone. How far does the robot lag behind? In theory |dr/dt| / KP.
    2. Add dr/dt (feedforward). Which error remains, and where does it come from?
    3. Make the point faster (W = 0.4). From which speed on can the robot not follow?

Commands
    setcmas check my_tracking    checks your solution
    setcmas run --algo my_tracking --pose 1:2,0,1.57 --duration 60
    setcmas metrics DIR                         mean error over the second half
"""

import numpy as np
import rviz_marker_array

task = 'tracking'  # selects its metrics and plots
exercise = 'traj_tracking'  # selects its tests

R = 2.0  # radius of the circle (m)
W = 0.2  # angular rate along the circle (rad/s)
KP = 0.8  # gain (1/s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that keeps the robot on the reference."""
    p = poses[:2, robotNo - 1]  # position of this robot (m)
    r = np.array([R, 0.0])  # TODO 1: where is the reference at time t?
    rviz_marker_array.publish_marker(r[0], r[1], 0, robotNo, [1, 1, 0], 0.1, 'traj_ref')
    r_dot = np.zeros(2)  # TODO 2: what is its velocity?
    v = np.zeros(2)  # TODO 3: compute v
    return v[0], v[1]
