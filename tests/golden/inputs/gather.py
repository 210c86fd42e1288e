"""A law with all that a script may do: state, random numbers, links, drawings, a gain to --set."""

import numpy as np
import rviz_marker
import rviz_marker_array

from setcmas_ctrl import network

task = 'consensus'
K = 0.5  # 1/s
calls = 0


def control(robotNo, nbRobots, poses, t):
    global calls
    calls += 1
    own = poses[:2, robotNo - 1]
    goal = own.copy()
    for j in network.neighbours():
        weight = network.adjacency()[robotNo - 1, j - 1]
        if np.isfinite(poses[0, j - 1]):
            goal += weight / nbRobots * (poses[:2, j - 1] - own)
    goal += 0.01 * np.random.randn(2)
    if calls % 5 == 1:
        rviz_marker.publish_marker(goal[0], goal[1], 0, robotNo, marker_name='goal')
        rviz_marker_array.publish_marker(own[0], own[1], 0, robotNo, marker_name='path')
    return K * (goal - own)
