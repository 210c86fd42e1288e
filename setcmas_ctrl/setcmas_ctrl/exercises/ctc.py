"""Exercise: the triggering condition. Robots are to talk only when they have something to tell.

Goal
    With --event-triggered a robot sends its state to the others only when its condition `ctc`
    (communication triggering condition) asks for it; in between, they go on with the last state
    that was sent. Find a condition with few messages and still a good consensus.

Formula to implement
    send if |p - p_sent| > THRESHOLD

    with p the robot's position now, and p_sent the one in the last state that it sent.

What to observe
    1. As it is, a robot sends at every evaluation. How many messages are that?
    2. Implement the condition. What part of the evaluations still triggers? When most of them?
    3. Compare THRESHOLD = 0.05, 0.25 and 1 m (edit this file): messages against the distance of
       the robots at the end. Is there a bound of that distance in terms of THRESHOLD?
    4. Let the threshold shrink with time, c0 + c1 exp(-a t). What is gained?

Commands
    setcmas new my_ctc --from ctc --exercise                a copy of this file for you to edit
    setcmas check my_ctc                                    what is right, and what is missing
    setcmas run --algo consensus --nb-robots 8 --duration 45 --event-triggered --ctc my_ctc
"""

import numpy as np

exercise = 'ctc'  # what setcmas check marks it by

THRESHOLD = 0.25  # (m)


def ctc(pos, last_pos, t):
    """Return whether the robot is to send its state now.

    pos and last_pos: x, y, z in m, now and in the last state that was sent; t: time in s.
    """
    # TODO: replace True by the condition
    return True
