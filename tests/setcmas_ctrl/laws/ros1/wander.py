#!/usr/bin/env python3
# -*- coding: utf-8 -*-
"""
Cyclic pursuit, module-level state, global, print, camelCase parameter names
"""
import numpy as np
import math
import rviz_marker

firstCall = True
counter = 0

def control(robotNo, nbRobots, poses, t):
    global firstCall, counter

    if firstCall:
        print("robot", robotNo, "of", nbRobots)
        firstCall = False
    counter = counter + 1

    nextRobot = robotNo % nbRobots
    k = 0.3
    vx = k*(poses[0,nextRobot] - poses[0,robotNo-1])
    vy = k*(poses[1,nextRobot] - poses[1,robotNo-1])
    rviz_marker.publish_marker(poses[0,nextRobot], poses[1,nextRobot], 0, robotNo)
    return vx, vy
