# run: zero_division.py, line 5: ZeroDivisionError: float division by zero
# run:     5 | return 1 / t, 0
# run: gets zero velocity; the other robots continue
def control(robotNo, nbRobots, poses, t):
    return 1 / t, 0
