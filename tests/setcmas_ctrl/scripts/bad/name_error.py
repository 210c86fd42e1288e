# run: name_error.py, line 4: NameError: name 'np' is not defined
# run:     4 | return np.cos(t), 0
def control(robotNo, nbRobots, poses, t):
    return np.cos(t), 0
