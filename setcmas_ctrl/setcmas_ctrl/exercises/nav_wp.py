"""Exercise: waypoint navigation. Each robot visits a list of waypoints again and again.

Goal
    Drive the robot from its position p to the current waypoint w. As soon as it is close enough,
    continue with the next waypoint; after the last, start again with the first. You may use the
    next waypoint in the same call, or from the next call on.

Formulas to implement
    v = KP (w - p)                                          (TODO 1)
    next waypoint if |w - p| < REACHED                      (TODO 2)

What to observe
    1. The path between two waypoints is not straight. Which property of a unicycle explains it?
    2. The speed is limited to vnom. Within which distance of a waypoint does KP matter?
    3. Make REACHED smaller (REACHED = 0.01). What happens, and why?

Commands
    setcmas check my_nav    checks your solution
    setcmas run --algo my_nav --pose 1:5,5,0 --duration 60
    setcmas metrics DIR                    arrival time at each waypoint
"""

import numpy as np
import rviz_marker

task = 'waypoints'  # selects its metrics and plots
exercise = 'nav_wp'  # selects its tests

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints (m)
KP = 0.8  # gain (1/s)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)

current = 0  # index of the current waypoint: a state; every robot has its own


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot to its current waypoint."""
    global current
    p = poses[:2, robotNo - 1]  # position of this robot (m)
    w = np.array(WPL[current])
    rviz_marker.publish_marker(w[0], w[1], 0, robotNo, [1, 1, 0], 0.3, 'wp_ref')
    v = np.zeros(2)
    # TODO 1: compute v
    # TODO 2: if the waypoint is reached, set `current` to the index of the next one
    return v[0], v[1]
