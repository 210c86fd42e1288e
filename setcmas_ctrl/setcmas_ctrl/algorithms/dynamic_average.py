"""Dynamic average consensus: robots follow the mean of targets of which each sees only its own.

Robot i sends its estimate x_i of the mean, which moves with its target r_i from call to call:

    x_i(k + 1) = x_i(k) - h K sum_j a_ij (x_i(k) - x_j(k)) + r_i(k + 1) - r_i(k), x_i(0) = r_i(0)
    v_i = KP (x_i - p_i) + x_i'

In a connected balanced graph the mean of all estimates is that of the targets. Targets start where
robots do; if they move at constant velocities r', the estimates differ from their mean by
pinv(K L) Pi r' in the long run, Pi r' = r' - mean(r'). Messages that are lost or late leave an
error for good.
Source: Spanos, Olfati-Saber and Murray, Dynamic consensus on mobile networks, IFAC World Congress,
2005; Kia, Van Scoy, Cortes, Freeman, Lynch and Martinez, Tutorial on dynamic average consensus,
IEEE Control Systems Magazine 39(3), 2019.
"""

import numpy as np
import rviz_marker

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band

task = 'consensus'  # selects its metrics and plots

K = 0.5  # gain of the estimates (1/s)
KP = 0.8  # gain of the position (1/s)
DRIFTS = [[0.1, 0.0], [0.0, 0.1], [0.1, 0.1]]  # velocities of targets 1, 2, ..., repeated (m/s)
SLOW = 0.01  # speed (m/s) below which robots stop

target = estimate = None  # r_i and x_i (m)
before = 0.0  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that moves the robot with its estimate of the mean."""
    global target, estimate, before
    position = poses[:2, robotNo - 1].copy()
    if target is None:
        target, estimate, before = position, position, t
    period, before = t - before, t
    drift = np.array(DRIFTS[(robotNo - 1) % len(DRIFTS)])
    weights = network.adjacency()[robotNo - 1]
    gaps = [weights[j - 1] * (one.value - estimate) for j, one in network.received().items()]
    rise = (period > 0) * (drift + K * sum(gaps))
    target, estimate = target + period * drift, estimate + period * rise
    network.send(estimate)
    rviz_marker.publish_marker(*target, 0, robotNo, [1, 0.6, 0], 0.3, 'target')
    vx, vy = KP * (estimate - position) + rise
    return dead_band(vx, vy, SLOW)
