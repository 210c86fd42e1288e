# load: replaces_a_builtin.py
# load: line 6: AttributeError: scripts cannot replace builtins.len

import builtins

builtins.len = max

def control(robotNo, nbRobots, poses, t):
    return 0.1, 0.1
