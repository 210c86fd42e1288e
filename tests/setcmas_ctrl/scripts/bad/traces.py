# load: traces.py
# load: line 6: ValueError: scripts cannot call sys.settrace

import sys

sys.settrace(lambda *_: 1 / 0)

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
