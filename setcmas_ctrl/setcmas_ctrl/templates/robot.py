"""My robot: describe in one line how it moves."""

import math

LARGEST_TURN_RATE = 1.0  # rad/s


def step(state, command, Ts):
    """Return the pose of the robot one period later: x (m), y (m) and heading theta (rad).

    Called ten times a second for every robot; every robot has its own copy of this file.

    state: x, y, theta
    command: speed forward and to the left (m/s), turn rate (rad/s)
    Ts: the period (s)
    """
    x, y, theta = state
    forward, left, omega = command

    omega = max(-LARGEST_TURN_RATE, min(LARGEST_TURN_RATE, omega))
    theta = theta + Ts * omega
    x = x + Ts * forward * math.cos(theta)
    y = y + Ts * forward * math.sin(theta)
    return x, y, theta


# If the state has more than the pose, such as the speed of a robot that accelerates slowly, define
# the state at the start; step then gets and returns as many numbers:
#
# def start(x, y, theta):
#     return x, y, theta, 0.0
#
# By default the robot is driven as a unicycle: it turns towards the velocity that the control law
# returns. A robot that can move sideways converts velocities (m/s, world frame) into commands:
#
# def command(velocity, pose):
#     vx, vy = velocity
#     x, y, theta = pose
#     forward = math.cos(theta) * vx + math.sin(theta) * vy
#     left = math.cos(theta) * vy - math.sin(theta) * vx
#     return forward, left, 0.0
