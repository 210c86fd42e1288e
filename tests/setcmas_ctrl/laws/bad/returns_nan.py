# run: returns_nan.py, line 3: control returned a value that is not finite: (nan, 0); is there a division by zero
def control(robotNo, nbRobots, poses, t):
    return float('nan'), 0
