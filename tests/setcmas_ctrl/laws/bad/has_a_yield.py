# load: has_a_yield.py: control has a yield; it must be a plain function that ends with return vx, vy
def control(robotNo, nbRobots, poses, t):
    yield 1, 2
