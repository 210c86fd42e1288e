import math

exercise = 'consensus'
K = 0.2


def control(robotNo, nbRobots, poses, t):
    vx = vy = 0.0
    for j in range(nbRobots):
        dx, dy = poses[0, j] - poses[0, robotNo - 1], poses[1, j] - poses[1, robotNo - 1]
        if not math.isnan(dx):
            vx, vy = vx + K * dx / nbRobots, vy + K * dy / nbRobots
    return vx, vy
