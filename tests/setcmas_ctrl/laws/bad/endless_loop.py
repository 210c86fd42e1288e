# run: control has not returned for 2 s; it is at endless_loop.py, line
# run: the robots of this process get no commands until it returns; Ctrl-C stops
def control(robotNo, nbRobots, poses, t):
    while True:
        pass
