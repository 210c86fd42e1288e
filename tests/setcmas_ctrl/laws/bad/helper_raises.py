# run: _helper_that_raises.py, line 2 (imported by helper_raises.py): KeyError: 'gain'
# run:     2 | return {}[name]
import _helper_that_raises


def control(robotNo, nbRobots, poses, t):
    return _helper_that_raises.value_of('gain'), 0
