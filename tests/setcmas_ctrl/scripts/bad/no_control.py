# load: no_control.py has no function control; expected is control(robotNo, nbRobots, poses, t)
K = 0.5
