# run: returns_none.py, line 3: control returned None: it reached its end without a return; it must return two finite numbers: return vx, vy
# run:     3 | def control(robotNo, nbRobots, poses, t):
def control(robotNo, nbRobots, poses, t):
    vx, vy = 1, 2
