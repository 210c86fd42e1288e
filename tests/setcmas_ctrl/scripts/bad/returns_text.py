# run: returns_text.py: control returned a str: '1, 2'
def control(robotNo, nbRobots, poses, t):
    return '1, 2'
