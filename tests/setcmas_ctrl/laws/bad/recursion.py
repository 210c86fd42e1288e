# run: recursion.py, line 3: RecursionError: maximum recursion depth exceeded
def control(robotNo, nbRobots, poses, t):
    return control(robotNo, nbRobots, poses, t)
