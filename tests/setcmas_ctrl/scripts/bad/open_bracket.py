# load: open_bracket.py, line 4: SyntaxError: '(' was never closed
# load:     4 |     vx = 2 * (poses[0, 0]
def control(robotNo, nbRobots, poses, t):
    vx = 2 * (poses[0, 0]
    return vx, 0
