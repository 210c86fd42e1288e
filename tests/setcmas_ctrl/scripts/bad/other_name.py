# load: other_name.py has no function control; did you mean Controll in line 2? it must have control(robotNo, nbRobots, poses, t)
def Controll(robotNo, nbRobots, poses, t):
    return 0, 0
