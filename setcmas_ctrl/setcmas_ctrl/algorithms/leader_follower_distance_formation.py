"""Leader-follower formation by distances: robots keep equal distances and follow robot 1.

The leader (robot 1) goes to its waypoint w; follower i moves with it and drives its distances
to all other robots towards D:

    v_1 = v_L = KL (w - p_1)
    v_i = v_L - (KF/N) sum_j (|p_i - p_j|^2 - D^2) (p_i - p_j)

All distances can only be equal for up to three robots; more robots settle where the sum is 0.
Source: S. Bertrand, SETCMAS, European Control Conference 2024; distance-based formation control
as in Krick, Broucke and Francis, Stabilisation of infinitesimally rigid formations of multi-robot
networks, International Journal of Control 82(3), 2009.
"""

import numpy as np
import rviz_marker

from setcmas_ctrl.saturation import dead_band

task = 'distances'  # selects its metrics and plots

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints of the leader (m)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)
KL = 0.8  # gain of the leader (1/s)
KF = 0.5  # gain of the followers (1/(m^2 s))
D = 3.0  # desired distance between robots (m)
SLOW = 0.01  # speed (m/s) below which robots stop

current = 0  # index of the leader's waypoint; every robot keeps its own


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of the leader or of a follower."""
    global current
    leader = poses[:2, 0]
    waypoint = WPL[current]
    leader_velocity = KL * (waypoint - leader)
    if np.linalg.norm(waypoint - leader) < REACHED:
        current = (current + 1) % len(WPL)  # from the next call on
    if robotNo == 1:
        rviz_marker.publish_marker(
            waypoint[0], waypoint[1], 0, robotNo, [1, 1, 0], 0.3, 'wp_ref', alpha=0.5
        )
        return dead_band(*leader_velocity, SLOW)
    towards_me = poses[:2, robotNo - 1, None] - poses[:2]
    stretch = np.sum(towards_me**2, axis=0) - D**2
    vx, vy = leader_velocity - KF / nbRobots * towards_me @ stretch
    return dead_band(vx, vy, SLOW)
