# run: control has not returned for 2 s; it is at sleeps.py, line 7
# run:     7 | time.sleep(10)
import time


def control(robotNo, nbRobots, poses, t):
    time.sleep(10)
    return 0, 0
