# load: exits_while_loading.py, line 4: SystemExit: the script called exit()
import sys

sys.exit()


def control(robotNo, nbRobots, poses, t):
    return 0, 0
