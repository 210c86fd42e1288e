# load: control_is_a_number.py has no function control; it must have control(robotNo, nbRobots, poses, t)
control = 3
