# run: returns_nan.py: control returned a value that is not finite: (nan, 0)
def control(robotNo, nbRobots, poses, t):
    return float('nan'), 0
