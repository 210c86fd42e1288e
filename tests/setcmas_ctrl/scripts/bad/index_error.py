# run: index_error.py, line 4: IndexError: index 99 is out of bounds for axis 1 with size
# run:     4 | return poses[0, 99], 0
def control(robotNo, nbRobots, poses, t):
    return poses[0, 99], 0
