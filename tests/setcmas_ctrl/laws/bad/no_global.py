# run: no_global.py, line 8: UnboundLocalError
# run: ; a function that changes calls must begin with `global calls`
# run:     8 | calls = calls + 1
calls = 0


def control(robotNo, nbRobots, poses, t):
    calls = calls + 1
    return 0, 0
