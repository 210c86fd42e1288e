"""Leader-follower formation: followers keep fixed places around a leader that visits waypoints.

The leader (robot 1) goes to its waypoint w, follower i to its place d_i relative to the leader:

    v_1 = v_L = KL (w - p_1)
    v_i = -KF ((p_i - p_1) - d_i) + v_L

Places of robots 2 to 5 are (-1.5, 0.866), (-1.5, -0.866), (1.5, -0.866), (1.5, 0.866) m; further
robots get the next places of the same triangular lattice, nearest to the leader first.
Source: S. Bertrand, SETCMAS, European Control Conference 2024; displacement-based formation
control as in Oh, Park and Ahn, A survey of multi-agent formation control, Automatica 53, 2015.
"""

import numpy as np
import rviz_marker

from setcmas_ctrl.saturation import dead_band

task = 'formation'  # selects its metrics and plots

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints of the leader (m)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)
KL = 0.8  # gain of the leader (1/s)
KF = 1.5  # gain of the followers (1/s)
PLACES = [(-1.5, 0.866), (-1.5, -0.866), (1.5, -0.866), (1.5, 0.866)]  # of robots 2 to 5 (m)
SLOW = 0.01  # speed (m/s) below which robots stop

current = 0  # index of the leader's waypoint; every robot keeps its own
place = None  # place of this robot relative to the leader (m)


def places_of(followers):
    """Return the places (m) of this many followers: PLACES first, then the rest of the lattice."""
    size = int(np.sqrt(followers)) + 3
    steps = range(-size, size + 1)
    lattice = [(1.5 * i, round(0.866 * i + 1.732 * j, 3)) for i in steps for j in steps]
    lattice.sort(key=lambda place: (round(np.hypot(*place), 2), np.arctan2(place[1], place[0])))
    others = [place for place in lattice[1:] if place not in PLACES]
    return PLACES + others[: max(0, followers - 4)]


def references(nbRobots):
    """Return the places of the followers, for metrics and plots."""
    return {'PLACES': places_of(max(1, nbRobots - 1))}


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of the leader or of a follower."""
    global current, place
    leader = poses[:2, 0]
    waypoint = WPL[current]
    leader_velocity = KL * (waypoint - leader)
    if np.linalg.norm(waypoint - leader) < REACHED:
        current = (current + 1) % len(WPL)  # from the next call on
    if robotNo == 1:
        rviz_marker.publish_marker(*waypoint, 0, robotNo, [1, 1, 0], 0.3, 'wp_ref')
        return dead_band(*leader_velocity, SLOW)
    if place is None:
        place = places_of(nbRobots - 1)[robotNo - 2]
    vx, vy = -KF * ((poses[:2, robotNo - 1] - leader) - place) + leader_velocity
    return dead_band(vx, vy, SLOW)
