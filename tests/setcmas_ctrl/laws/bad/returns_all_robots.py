# run: values in 3 x 2: array(
# run: it must return two finite numbers: return vx, vy
def control(robotNo, nbRobots, poses, t):
    return -poses
