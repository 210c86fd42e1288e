"""Exercise: leader-follower formation. Robots are to keep their places around a leader.

Goal
    Robot 1, the leader, visits waypoints: its law is given. Follower i is to reach its place d_i
    beside the leader, and to keep it while the leader moves.

Formula to implement
    v_i = -KF ((p_i - p_1) - d_i) + v_1

    with the velocity v_1 of the leader, which every robot can compute from the leader's position.

What to observe
    1. Leave out v_1 first. How far do the followers stay behind? Theory says |v_1| / KF.
    2. Add v_1. What is left of the error while the leader turns, and why?
    3. The formation does not turn with the leader. Which measurement would it need for that?

Commands
    setcmas new my_formation --from leader_follower_formation --exercise    a copy to edit
    setcmas check my_formation                                              what is missing
    setcmas run --algo my_formation --nb-robots 5 --duration 60
    setcmas metrics DIR --task formation                    the errors of the places
"""

import numpy as np
import rviz_marker

task = 'formation'  # what it is measured by, and drawn with
exercise = 'leader_follower_formation'  # what setcmas check marks it by

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints of the leader (m)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)
KL = 0.8  # gain of the leader (1/s)
KF = 1.5  # gain of the followers (1/s)
PLACES = [(-1.5, 0.866), (-1.5, -0.866), (1.5, -0.866), (1.5, 0.866)]  # of robots 2 to 5 (m)

current = 0  # index of the leader's waypoint: state, which every robot keeps for itself


def control(robotNo, nbRobots, poses, t):
    """Return the velocity (vx, vy) in m/s of the leader or of a follower."""
    global current
    leader = poses[:2, 0]  # p_1 (m)
    waypoint = np.array(WPL[current])
    v_leader = KL * (waypoint - leader)
    if np.linalg.norm(waypoint - leader) < REACHED:
        current = (current + 1) % len(WPL)
    if robotNo == 1:
        rviz_marker.publish_marker(waypoint[0], waypoint[1], 0, 1, [1, 1, 0], 0.3, 'wp_ref')
        # TODO 1: let the leader go, with v_leader, once the followers have something to follow
        return 0, 0
    if robotNo - 2 >= len(PLACES):
        return 0, 0  # there are places for four followers
    p = poses[:2, robotNo - 1]  # position of this follower (m)
    place = np.array(PLACES[robotNo - 2])  # d_i (m)
    v = np.zeros(2)  # TODO 2: choose v from p, leader, place, KF and v_leader
    return v[0], v[1]
