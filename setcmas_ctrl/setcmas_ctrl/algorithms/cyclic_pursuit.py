"""Cyclic pursuit: each robot pursues the next, at an angle.

    v_i = K R(alpha) (p_(i+1) - p_i), the last robot pursues the first

with the rotation R by alpha. A robot that does not receive the next one stands still. For
alpha = 0 the robots meet at their mean at the rate 2 K sin^2(pi/N). For alpha = pi/N they end on a
circle, equally spaced, and drive along it with 2 K sin(pi/N) rad/s; for a larger alpha (below
2 pi/N) they spiral outwards.
Source: Pavone and Frazzoli, Decentralized policies for geometric pattern formation and path
coverage, Journal of Dynamic Systems, Measurement, and Control 129(5), 2007; Marshall, Broucke and
Francis, Formations of vehicles in cyclic pursuit, IEEE Transactions on Automatic Control 49(11),
2004.
"""

import numpy as np

from setcmas_ctrl.saturation import dead_band

K = 0.05  # gain (1/s)
ALPHA = None  # angle (rad); pi/N by default: a circle
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of the pursuit of the next robot."""
    x, y = poses[:2, robotNo % nbRobots] - poses[:2, robotNo - 1]
    v = turned(nbRobots) * (x + 1j * y)
    return dead_band(v.real, v.imag, SLOW) if np.isfinite(v) else (0.0, 0.0)  # not received


def turned(nbRobots):
    """Return the gain as a complex number that turns by ALPHA."""
    return K * np.exp(1j * (np.pi / nbRobots if ALPHA is None else ALPHA))
