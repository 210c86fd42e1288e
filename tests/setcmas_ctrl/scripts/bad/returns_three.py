# run: returns_three.py: control returned 3 values: (1, 2, 0)
def control(robotNo, nbRobots, poses, t):
    return 1, 2, 0
