# load: replaces_numpy.py
# load: line 6: AttributeError: scripts cannot replace numpy.cos

import numpy as np

np.cos = np.sin

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
