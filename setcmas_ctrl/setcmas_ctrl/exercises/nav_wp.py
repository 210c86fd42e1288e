"""Exercise: waypoint navigation. Each robot is to visit a list of waypoints, over and over.

Goal
    Drive the robot, whose position is p, to the current waypoint w; take the next one as soon as
    the robot is close enough, and the first one after the last.

Formulas to implement
    v = KP (w - p)                                          (TODO 1)
    next waypoint if |w - p| < REACHED                      (TODO 2)

What to observe
    1. The path between two waypoints is no straight line. Which part of the robot is the cause?
       (README: robots are unicycles.)
    2. The speed is cut to --vnom. From which distance on does the gain KP matter at all?
    3. Make REACHED smaller (--set REACHED=0.01). What happens, and why?

Commands
    setcmas new my_nav --from nav_wp --exercise             a copy of this file for you to edit
    setcmas check my_nav                                    what is right, and what is missing
    setcmas run --algo my_nav --pose 1:5,5,0 --duration 60
    setcmas metrics DIR --task waypoints                    when each waypoint was reached
"""

import numpy as np
import rviz_marker

task = 'waypoints'  # what it is measured by, and drawn with
exercise = 'nav_wp'  # what setcmas check marks it by

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints (m)
KP = 0.8  # gain (1/s)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)

current = 0  # index of the current waypoint: state, which every robot keeps for itself


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that leads the robot to its current waypoint."""
    global current
    p = poses[:2, robotNo - 1]  # position of this robot (m)
    w = np.array(WPL[current])
    rviz_marker.publish_marker(w[0], w[1], 0, robotNo, [1, 1, 0], 0.3, 'wp_ref')
    v = np.zeros(2)
    # TODO 1: choose v
    # TODO 2: if the waypoint is reached, let `current` be the index of the next one
    return v[0], v[1]
