# load: no_control.py has no function control; it must have control(robotNo, nbRobots, poses, t)
K = 0.5
