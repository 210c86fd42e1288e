"""Connectivity-preserving rendezvous: robots with sensing range D meet without losing links.

    v_i = -K sum_j (2 D - l_ij) / (D - l_ij)^2 (p_i - p_j) over the robots j within D

with the length l_ij of the link. The weight grows without bound as a link comes near D, so no link
that is shorter than D at the start is ever lost. The law, called at intervals h (H at first),
limits the speed to (D - l)/(2 h) with the longest link l < D, so that no link grows beyond D
before the next call, unless messages are late or lost. Run it with a range of D.
Source: Ji and Egerstedt, Distributed coordination control of multiagent systems while preserving
connectedness, IEEE Transactions on Robotics 23(4), 2007.
"""

import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.saturation import dead_band, saturate

task = 'consensus'  # selects its metrics and plots

K = 0.1  # gain (m/s)
D = 6.0  # range (m), as that of the run
MARGIN = 0.999  # of D, beyond which the weight does not grow any more
H = 0.2  # longest interval (s) between the first two calls
SLOW = 0.01  # speed (m/s) below which robots stop

before = None  # time of the call before (s)


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s towards the robots in range."""
    global before
    near = [j - 1 for j in network.neighbours()]
    gaps = poses[:2, robotNo - 1, None] - poses[:2, near]
    lengths = np.hypot(*gaps)
    period, before = H if before is None else t - before, t
    held = np.minimum(lengths, MARGIN * D)
    weights = (2 * D - held) / (D - held) ** 2
    velocity = dead_band(*(-K * np.nansum(weights * gaps, axis=1)), SLOW)
    left = np.min(D - lengths[lengths < D], initial=np.inf)
    return saturate(velocity, left / (2 * max(period, 1e-9)))
