# run: own_exception.py, line 8: Lost
# run:     8 | raise Lost
class Lost(Exception):
    pass


def control(robotNo, nbRobots, poses, t):
    raise Lost
