# load: tabs_and_spaces.py, line 5: TabError: inconsistent use of tabs and spaces in indentation
def control(robotNo, nbRobots, poses, t):
    if t > 1:
        vx = 1
	return 1, 2
