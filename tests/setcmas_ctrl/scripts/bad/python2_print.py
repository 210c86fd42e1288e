# load: python2_print.py, line 3: SyntaxError: Missing parentheses in call to 'print'
def control(robotNo, nbRobots, poses, t):
    print "here"
    return 0, 0
