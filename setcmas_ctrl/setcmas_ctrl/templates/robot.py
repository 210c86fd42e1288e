"""My robot: one line that says how it moves."""

import math

LARGEST_TURN_RATE = 1.0  # rad/s


def step(state, command, Ts):
    """Return where the robot is a period later: x (m), y (m) and heading theta (rad).

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


# A robot whose state is more than its pose, such as one that takes time to speed up, says how it
# starts; step then gets, and returns, as many numbers:
#
# def start(x, y, theta):
#     return x, y, theta, 0.0
#
# A robot is driven as a unicycle, which turns towards the velocity that the control law wants. One
# that goes sideways turns velocities (m/s, world frame) into commands itself:
#
# def command(velocity, pose):
#     vx, vy = velocity
#     x, y, theta = pose
#     forward = math.cos(theta) * vx + math.sin(theta) * vy
#     left = math.cos(theta) * vy - math.sin(theta) * vx
#     return forward, left, 0.0
