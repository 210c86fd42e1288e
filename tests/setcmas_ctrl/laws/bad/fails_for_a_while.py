# run: fails_for_a_while.py, line 6: RuntimeError: not yet
# run: works again after
# run: calls
def control(robotNo, nbRobots, poses, t):
    if t < 1:
        raise RuntimeError('not yet')
    return 0, 0
