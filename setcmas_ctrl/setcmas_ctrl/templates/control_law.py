"""My control law: describe in one line what the robots do."""

import numpy as np

K = 0.5  # gain (1/s)

# Keep state in variables here. Every robot has its own copy of this file and its variables.
calls = 0


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) of robot robotNo, in m/s in the world frame.

    Called five times a second for every robot.

    robotNo: number of this robot, from 1 to nbRobots
    poses: one column per robot; rows x (m), y (m) and heading theta (rad)
    t: time since the start of the run (s), the same for all robots
    """
    global calls
    calls += 1

    x, y, theta = poses[:, robotNo - 1]  # robots count from 1, columns from 0
    centre_x, centre_y = np.mean(poses[:2], axis=1)  # average position of all robots

    vx = K * (centre_x - x)
    vy = K * (centre_y - y)

    # The terminal shows the robot's name before each printed line.
    if calls == 1:
        print(f'I start at ({x:.1f}, {y:.1f}) m')

    return vx, vy
