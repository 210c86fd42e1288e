# load: raises_while_loading.py, line 3: ZeroDivisionError: division by zero
# load:     3 | PERIOD = 1 / 0
PERIOD = 1 / 0


def control(robotNo, nbRobots, poses, t):
    return 0, 0
