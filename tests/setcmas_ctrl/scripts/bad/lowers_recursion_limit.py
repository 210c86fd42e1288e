# load: lowers_recursion_limit.py
# load: line 6: ValueError: scripts cannot lower the recursion limit

import sys

sys.setrecursionlimit(40)

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
