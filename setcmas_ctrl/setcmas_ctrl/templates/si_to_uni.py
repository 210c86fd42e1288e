"""My si_to_uni: describe in one line how it drives the robot."""

from math import atan2, hypot, pi

SLOW = 0.01  # speed (m/s) and turn rate (rad/s) below which robots do not turn


def si_to_uni(velocity, pose, komega):
    """Return the command of a unicycle: forward speed (m/s) and turn rate (rad/s).

    Called five times a second for every robot; every robot has its own copy of this file.

    velocity: vx, vy that the control law returned (m/s)
    pose: x, y (m) and heading theta (rad) of the robot
    komega: gain (1/s), --komega
    """
    vx, vy = velocity
    x, y, theta = pose

    V = hypot(vx, vy)
    error = atan2(vy, vx) - theta
    error = pi - (pi - error) % (2 * pi)  # from -pi to pi: turn the short way
    omega = komega * error
    if V < SLOW or abs(omega) < SLOW:
        omega = 0.0
    return V, omega
