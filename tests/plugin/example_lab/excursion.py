"""The metric `excursion`: how far each robot was from its start at most."""

import numpy as np

from setcmas_tools.measures.metric import Value


def excursion(run):
    """Return the largest distance of each robot from where it was at t = 0, in m."""
    farthest = {}
    for robot in run.counted.robots:
        track = run.counted.of(robot)
        away = np.hypot(track.x - track.x[0], track.y - track.y[0])
        farthest[robot] = float(away.max())
    return Value('excursion', farthest, 'm')
