# load: other_name.py has no function control; Controll in line 2 must be called control; it must have control(robotNo, nbRobots, poses, t)
def Controll(robotNo, nbRobots, poses, t):
    return 0, 0
