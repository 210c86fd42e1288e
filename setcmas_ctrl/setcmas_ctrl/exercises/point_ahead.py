"""Exercise: a point ahead of the axle. It can go in any direction, although the robot cannot.

Goal
    The axle of a unicycle cannot move sideways, but the point P at a distance L ahead of it can.
    Drive the robot so that P has the velocity v that the control law returns: the speed V along
    the heading theta, and the turn rate omega, replace the built-in si_to_uni.

Formula to implement
    V = vx cos(theta) + vy sin(theta)                       (TODO 1)
    omega = (vy cos(theta) - vx sin(theta)) / L             (TODO 2)

    It is an input-output linearisation (Siciliano et al., Robotics: Modelling, Planning and
    Control, 2009, section 11.6).

What to observe
    1. Write P as x + L cos(theta), y + L sin(theta), and derive the formula from its velocity.
    2. Compare the path with that of the built-in si_to_uni: which robot
       swings out wide, which one drives backwards, and when?
    3. For a constant v the heading error e obeys e' = -(|v| / L) sin(e), and the function is
       called every 0.2 s. At 0.5 m/s, for which L does the heading oscillate, and for which does
       it not settle at all? Try L = 0.15, 0.08 and 0.04 m.
    4. With a law for the axle, such as consensus, do the axles meet, or the points?

Commands
    setcmas check my_point_ahead    checks your solution
    setcmas run --algo nav_wp --pose 1:5,5,0 --duration 60 --si-to-uni my_point_ahead
"""

from math import cos, sin

exercise = 'point_ahead'  # selects its tests

L = 0.15  # distance of P from the axle (m)


def si_to_uni(velocity, pose, komega):
    """Return the forward speed V (m/s) and the turn rate omega (rad/s).

    velocity: vx, vy of the control law (m/s); pose: x, y (m), theta (rad); komega: not needed.
    """
    vx, vy = velocity
    x, y, theta = pose

    V = 0.0  # TODO 1
    omega = 0.0  # TODO 2
    return V, omega
