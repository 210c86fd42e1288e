"""Each robot goes straight to the place opposite its start: v_i = K (goal_i - p_i)."""

K = 1.0  # gain (1/s)

goal = None  # of this robot (m): minus its start


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the goal."""
    global goal
    here = poses[:2, robotNo - 1]
    if goal is None:
        goal = -here
    vx, vy = K * (goal - here)
    return vx, vy
