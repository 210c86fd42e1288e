"""Exercise: the triggering condition. Robots send their state only when necessary.

Goal
    With event-triggered communication a robot sends its state only when its triggering
    condition `ctc` holds; in between, all laws, its own too, use the last state that it sent.
    Find a condition that needs few messages and still gives a good consensus.

Formula to implement
    send if |p - p_sent| > THRESHOLD

    where p is the robot's position now, and p_sent its position in the last state it sent.

What to observe
    1. Without changes, a robot sends at every evaluation. How many messages is that?
    2. Implement the condition. What share of the evaluations still triggers? When do most?
    3. Compare THRESHOLD = 0.05, 0.25 and 1 m (edit this file): number of messages against the
       final distance of the robots. Can you bound this distance in terms of THRESHOLD?
    4. Let the threshold decrease with time, c0 + c1 exp(-a t). What do you gain?

Commands
    setcmas check my_ctc    checks your solution
    setcmas run --algo consensus --nb-robots 8 --duration 45 --event-triggered --ctc my_ctc
"""

import numpy as np

exercise = 'ctc'  # selects its tests

THRESHOLD = 0.25  # (m)


def ctc(pos, last_pos, t):
    """Return whether the robot sends its state now.

    pos and last_pos: x, y, z in m, now and in the last state sent; t: time in s.
    """
    # TODO: replace True with the condition
    return True
