# run: returns_none.py: control returned None (is a return missing?); it must return two finite numbers: return vx, vy
# run:     3 | def control(robotNo, nbRobots, poses, t):
def control(robotNo, nbRobots, poses, t):
    vx, vy = 1, 2
