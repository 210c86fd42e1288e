from math import *
import sys, os, time
from random import random
import rviz_marker, rviz_marker_array

# lambda, default arguments, sys.stdout.write, integers as the result
gain = lambda d: 0.5 if d > 1 else 0.2
log = []
START = time.time()

def control(robotNo, nbRobots, poses, t, verbose=True):
    def towards(x, y):
        dx, dy = x - poses[0][robotNo-1], y - poses[1][robotNo-1]
        d = sqrt(dx**2 + dy**2)
        return gain(d)*dx, gain(d)*dy
    log.append((t, poses[:, robotNo-1]))
    if verbose and len(log) == 3:
        sys.stdout.write('third ')
        sys.stdout.write('call\n')
    if t < 0.5:
        return 1, 0
    v = towards(0, 0)
    poses[:, robotNo-1] = 0
    return v
