# run: returns_inf.py: control returned a value that is not finite: (0.0, -inf)
def control(robotNo, nbRobots, poses, t):
    return 0.0, -float('inf')
