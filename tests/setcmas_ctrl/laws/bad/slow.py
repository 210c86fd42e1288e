# run: slow.py took 0.
# run: longer than the control period of 0.20 s (1 time so far)
import time


def control(robotNo, nbRobots, poses, t):
    time.sleep(0.3)
    return 0, 0
