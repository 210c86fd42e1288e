# run: returns_one.py: control returned 1 value: 1.5
def control(robotNo, nbRobots, poses, t):
    return 1.5
