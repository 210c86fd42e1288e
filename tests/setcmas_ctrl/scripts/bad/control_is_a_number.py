# load: control_is_a_number.py has no function control; expected is control(robotNo, nbRobots, poses, t)
control = 3
