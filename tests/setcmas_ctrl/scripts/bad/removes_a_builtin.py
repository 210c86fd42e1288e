# load: removes_a_builtin.py
# load: line 6: AttributeError: scripts cannot replace builtins.zip

import builtins

del builtins.zip

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
