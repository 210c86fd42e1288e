"""Exercise: leader-follower formation. Robots keep their places around a leader.

Goal
    Robot 1, the leader, visits waypoints; its velocity v_leader is given, but robot 1 does not
    move before TODO 1. Follower i reaches its place d_i, relative to the leader, and keeps it
    while the leader moves.

Formula to implement
    v_i = -KF ((p_i - p_1) - d_i) + v_1

    where v_1 is the leader's velocity, which every robot can compute from its position.

What to observe
    1. Leave out v_1 first. How far do the followers lag behind? In theory |v_1| / KF.
    2. Add v_1. Which error remains while the leader turns, and why?
    3. The formation does not turn with the leader. Which measurement would that require?

Commands
    setcmas check my_formation    checks your solution
    setcmas run --algo my_formation --nb-robots 5 --duration 60
    setcmas metrics DIR                    position errors of the followers
"""

import numpy as np
import rviz_marker

task = 'formation'  # selects its metrics and plots
exercise = 'leader_follower_formation'  # selects its tests

WPL = [[2, 2], [-2, 2], [-2, -2], [2, -2], [2, 2]]  # waypoints of the leader (m)
REACHED = 0.10  # a waypoint counts as reached at this distance (m)
KL = 0.8  # gain of the leader (1/s)
KF = 1.5  # gain of the followers (1/s)
PLACES = [(-1.5, 0.866), (-1.5, -0.866), (1.5, -0.866), (1.5, 0.866)]  # of robots 2 to 5 (m)

current = 0  # index of the leader's waypoint: a state; every robot has its own


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
        # TODO 1: return v_leader instead, once the followers can follow
        return 0, 0
    if robotNo - 2 >= len(PLACES):
        return 0, 0  # only four followers have places
    p = poses[:2, robotNo - 1]  # position of this follower (m)
    place = np.array(PLACES[robotNo - 2])  # d_i (m)
    v = np.zeros(2)  # TODO 2: choose v from p, leader, place, KF and v_leader
    return v[0], v[1]
