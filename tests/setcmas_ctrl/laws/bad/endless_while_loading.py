# run: endless_while_loading.py has been loading for 2 s; it is at endless_while_loading.py, line
while True:
    pass


def control(robotNo, nbRobots, poses, t):
    return 0, 0
