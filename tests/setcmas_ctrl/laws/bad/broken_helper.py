# load: _helper_with_a_mistake.py, line 2 (imported by broken_helper.py): SyntaxError: invalid syntax
# load:     2 |     return 2 **
import _helper_with_a_mistake


def control(robotNo, nbRobots, poses, t):
    return _helper_with_a_mistake.twice(0), 0
