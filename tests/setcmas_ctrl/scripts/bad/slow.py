# run: slow.py took 0.
# run: longer than the control period of 0.20 s (so far 1 times)
import time


def control(robotNo, nbRobots, poses, t):
    time.sleep(0.3)
    return 0, 0
