# run: values: array(
# run: expected are two finite numbers: return vx, vy
def control(robotNo, nbRobots, poses, t):
    return -poses
