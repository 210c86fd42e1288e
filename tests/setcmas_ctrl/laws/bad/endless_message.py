# run: endless_message.py, line 4: ValueError: xxxxxxxxxxxx
# run: xxx...
def control(robotNo, nbRobots, poses, t):
    raise ValueError('x' * 100_000)
