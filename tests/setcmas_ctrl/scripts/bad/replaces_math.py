# load: replaces_math.py
# load: line 6: AttributeError: scripts cannot replace math.hypot

import math

math.hypot = max

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
