"""My control law: one line that says what the robots do (`setcmas list` shows it)."""

import numpy as np

K = 0.5  # gain (1/s); `--set K=1.2` tries another value without editing

# State is kept in names out here. Every robot has its own copy of this file and its names.
calls = 0


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s, in the world frame, of robot number robotNo.

    Called five times a second for every robot.

    robotNo: number of this robot, from 1 to nbRobots
    poses: a column for each robot; rows x (m), y (m) and heading theta (rad)
    t: time since the start of the run (s), the same for all robots
    """
    global calls
    calls += 1

    x, y, theta = poses[:, robotNo - 1]  # robots count from 1, columns from 0
    centre_x, centre_y = np.mean(poses[:2], axis=1)  # average position of all robots

    vx = K * (centre_x - x)
    vy = K * (centre_y - y)

    # What a script prints is shown with the robot's name before it.
    if calls == 1:
        print(f'I start at ({x:.1f}, {y:.1f}) m')

    return vx, vy
