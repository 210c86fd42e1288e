# run: replaces_numpy_while_running.py, line 8
# run: AttributeError: scripts cannot replace numpy.linalg.norm

import numpy as np


def control(robotNo, nbRobots, poses, t):
    np.linalg.norm = max
    return 0.1, 0.1
