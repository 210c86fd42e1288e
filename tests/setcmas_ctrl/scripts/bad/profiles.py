# load: profiles.py
# load: line 6: ValueError: scripts cannot call sys.setprofile

import sys

sys.setprofile(lambda *_: 1 / 0)

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
