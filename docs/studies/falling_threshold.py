"""Triggering condition with a threshold that falls: |p - p_sent| > C0 + C1 exp(-A t).

Robots send finitely many messages in finite time, and come as near to each other as C0 allows.
Source: Seyboth, Dimarogonas and Johansson, Event-based broadcasting for multi-agent average
consensus, Automatica 49(1), 2013.
"""

import numpy as np

C0 = 0.02  # m
C1 = 1.0  # m
A = 0.1  # rate at which the threshold falls (1/s); below lambda_2 of the law


def ctc(pos, last_pos, t):
    """Return whether the robot sends its state."""
    return bool(np.linalg.norm(pos - last_pos) > C0 + C1 * np.exp(-A * t))
