"""Seyboth et al.: a threshold that falls with time, and needs no neighbour.

    send if |p_i - p_i_sent| > C0 + C1 exp(-ALPHA t)

If ALPHA is less than the rate K lambda_2 of p' = -K L p_sent, no robot sends infinitely often in
finite time, and an undirected connected graph comes within |L| C0 / lambda_2 of agreement (RMS
distance from the mean of the starts): with C0 = 0 all robots meet there.
Source: Seyboth, Dimarogonas and Johansson, Event-based broadcasting for multi-agent average
consensus, Automatica 49(1), 2013.
"""

import numpy as np

C0 = 0.02  # m
C1 = 1.0  # m
ALPHA = 0.1  # rate at which the threshold falls (1/s)


def ctc(pos, last_pos, t):
    """Return whether the robot sends its state."""
    return np.linalg.norm(pos - last_pos) > C0 + C1 * np.exp(-ALPHA * t)
