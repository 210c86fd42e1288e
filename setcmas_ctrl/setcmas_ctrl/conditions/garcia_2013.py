"""Garcia et al.: the error is small against the distances to the neighbours, as received last.

    send if |p_i - p_i_sent|^2 > SIGMA a (1 - a d_i) / d_i |z_i|^2,
    z_i = sum_j (p_i_sent - p_j_sent)

with d_i neighbours j, 0 < SIGMA < 1 and 0 < a < 1 / d_i; a = 1 / (2 d_i) sends least often. With
p' = -K L p_sent and the same a for all, robots of an undirected connected graph meet at the mean
of their starts: here, if all have equally many neighbours. In other graphs take a common a in
ctc, below 1 / the largest number of neighbours. They measure nothing of their neighbours. Until
one of these sends, the error grows at the speed K |z_i|, so a robot sends after
sqrt(SIGMA) / (2 K d_i).
Source: Garcia, Cao, Yu, Antsaklis and Casbeer, Decentralised event-triggered cooperative control
with limited communication, International Journal of Control 86(9), 2013.
"""

import numpy as np

SIGMA = 0.5


def ctc(pos, last_pos, t, *, received):
    """Return whether the robot sends its state."""
    gaps = last_pos[:2, None] - received[:2]
    degree = np.isfinite(gaps[0]).sum()
    a = 1 / (2 * max(degree, 1))
    most = SIGMA * a * (1 - a * degree) / max(degree, 1)
    return np.sum((pos - last_pos) ** 2) > most * np.sum(np.nansum(gaps, axis=1) ** 2)
