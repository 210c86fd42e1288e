# load: missing_module.py, line 3: ModuleNotFoundError: No module named 'nunpy'
# load:     3 | import nunpy as np
import nunpy as np


def control(robotNo, nbRobots, poses, t):
    return 0, 0
