# run: exits.py, line 6: SystemExit: the script called exit()
import sys


def control(robotNo, nbRobots, poses, t):
    sys.exit()
