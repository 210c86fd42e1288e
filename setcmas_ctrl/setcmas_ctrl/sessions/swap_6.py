"""Each robot goes to the place opposite its start: v_i = K R(-turn) (goal_i - p_i)."""

import math

K = 1.0  # gain (1/s)
turn = 0.0  # angle by which it heads to the right of its goal (degrees)

goal = None  # of this robot (m): minus its start


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the goal."""
    global goal
    here = poses[:2, robotNo - 1]
    if goal is None:
        goal = -here
    x, y = K * (goal - here)
    cos, sin = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    return cos * x + sin * y, cos * y - sin * x
