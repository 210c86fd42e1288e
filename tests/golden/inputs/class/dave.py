exercise = 'consensus'


def control(robotNo, nbRobots, poses):
    return 0, 0
