"""Resilient consensus (W-MSR): honest robots agree even if up to F robots disobey the law.

For each coordinate, robot i sorts the values of its neighbours and ignores the F largest of those
above its own and the F smallest of those below; with the remaining neighbours N_i:

    v_i = K / (1 + |N_i|) sum over j in N_i of (p_j - p_i)

If K h <= 1 with the sampling period h, honest robots stay in the interval of their starts. They
meet if the graph is (2F + 1)-robust; a complete graph is ceil(N/2)-robust.
Source: LeBlanc, Zhang, Koutsoukos and Sundaram, Resilient asymptotic consensus in robust networks,
IEEE Journal on Selected Areas in Communications 31(4), 2013.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'resilience'  # selects its metrics and plots

K = 0.5  # gain (1/s)
F = 1  # robots that may not follow the law
REBELS = [1]  # robots that do not: they drive along a circle
RADIUS = 3.0  # of the circle (m)
W = 0.1  # angular rate along it (rad/s)
SLOW = 0.01  # speed (m/s) below which robots stop


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of an honest robot or of a rebel."""
    if robotNo in REBELS:
        return -RADIUS * W * np.sin(W * t), RADIUS * W * np.cos(W * t)
    gaps = poses[:2, [j - 1 for j in network.neighbours()]] - poses[:2, robotNo - 1, None]
    gaps = gaps[:, np.isfinite(gaps[0])]  # of robots from which it has received something
    return dead_band(K * mean_of_trusted(gaps[0]), K * mean_of_trusted(gaps[1]), SLOW)


def mean_of_trusted(gaps):
    """Return the sum of the gaps that remain, divided by 1 + their number."""
    above, below = np.sort(gaps[gaps > 0]), np.sort(gaps[gaps < 0])
    left = [*above[: max(len(above) - F, 0)], *below[F:], *gaps[gaps == 0]]
    return sum(left) / (1 + len(left))
