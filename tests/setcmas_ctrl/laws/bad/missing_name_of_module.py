# load: missing_name_of_module.py, line 3: ImportError: cannot import name 'sinus' from 'math'
# load:     3 | from math import sinus
from math import sinus


def control(robotNo, nbRobots, poses, t):
    return sinus(t), 0
