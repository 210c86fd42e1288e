# run: shapes.py, line 7: ValueError: operands could not be broadcast together
# run:     7 | v = poses[:, 0] - np.zeros(2)
import numpy as np


def control(robotNo, nbRobots, poses, t):
    v = poses[:, 0] - np.zeros(2)
    return v[0], v[1]
