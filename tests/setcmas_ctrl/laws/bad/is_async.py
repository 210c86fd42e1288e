# load: is_async.py: control is async; it must be a plain function that ends with return vx, vy
async def control(robotNo, nbRobots, poses, t):
    return 1, 2
