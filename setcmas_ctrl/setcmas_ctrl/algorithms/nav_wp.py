"""Waypoint navigation: each robot visits the same list of waypoints again and again.

Proportional control of a single integrator p' = v towards the current waypoint w:

    v = KP (w - p)

The robot continues with the next waypoint within 0.10 m of the current one.
Source: S. Bertrand, SETCMAS, European Control Conference 2024; proportional regulation of a
single integrator as in Mesbahi and Egerstedt, Graph Theoretic Methods in Multiagent Networks,
2010, chapter 3.
"""

import numpy as np
import rviz_marker

from setcmas_ctrl.saturation import dead_band

task = 'waypoints'  # selects its metrics and plots

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints (m)
KP = 0.8  # gain (1/s)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)
SLOW = 0.01  # speed (m/s) below which robots stop

current = 0  # index of the current waypoint


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot to its current waypoint."""
    global current
    waypoint = WPL[current]
    rviz_marker.publish_marker(
        waypoint[0], waypoint[1], 0, robotNo, [1, 1, 0], 0.3, 'wp_ref', alpha=0.5
    )
    to_waypoint = waypoint - poses[:2, robotNo - 1]
    if np.linalg.norm(to_waypoint) < REACHED:
        current = (current + 1) % len(WPL)  # from the next call on
    vx, vy = KP * to_waypoint
    return dead_band(vx, vy, SLOW)
