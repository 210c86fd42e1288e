"""Solution of the exercise point_ahead: a point ahead of the axle has the velocity of the law."""

from math import cos, sin

L = 0.15  # distance of the point from the axle (m)


def si_to_uni(velocity, pose, komega):
    """Return the forward speed V (m/s) and the turn rate omega (rad/s).

    Siciliano et al., Robotics: Modelling, Planning and Control, 2009, section 11.6.
    """
    vx, vy = velocity
    x, y, theta = pose

    V = vx * cos(theta) + vy * sin(theta)
    omega = (vy * cos(theta) - vx * sin(theta)) / L
    return V, omega
