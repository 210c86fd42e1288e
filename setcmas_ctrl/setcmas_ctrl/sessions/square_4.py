"""Four robots form a square by distances.

    v_i = -K sum_j (|p_i - p_j|^2 - d_ij^2) (p_i - p_j)    over the links of robot i

Source: Krick, Broucke and Francis, Stabilisation of infinitesimally rigid formations of
multi-robot networks, International Journal of Control 82(3), 2009.
"""

import numpy as np

SIDE = 2.0  # of the square (m)
LINKS = {(1, 2): SIDE, (2, 3): SIDE, (3, 4): SIDE, (4, 1): SIDE}  # distances of two robots (m)
K = 0.1  # gain (1/(m^2 s))


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s that drives the distances of this robot's links."""
    here = poses[:2, robotNo - 1]
    v = np.zeros(2)
    for link, distance in LINKS.items():
        if robotNo in link:
            other = link[0] if robotNo == link[1] else link[1]
            gap = here - poses[:2, other - 1]
            v -= K * (gap @ gap - distance**2) * gap
    return v[0], v[1]
