# run: keyboard_interrupt.py, line 4: KeyboardInterrupt
# run:     4 | raise KeyboardInterrupt
def control(robotNo, nbRobots, poses, t):
    raise KeyboardInterrupt
