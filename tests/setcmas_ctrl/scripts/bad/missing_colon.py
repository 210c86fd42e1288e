# load: missing_colon.py, line 3: SyntaxError: expected ':'
# load:     3 | def control(robotNo, nbRobots, poses, t)
def control(robotNo, nbRobots, poses, t)
    return 1, 2
