"""The metric `excursion`: largest distance of each robot from its start."""

import numpy as np

from setcmas_tools.measures.metric import Value


def excursion(run):
    """Return the largest distance of each robot from its position at t = 0, in m."""
    farthest = {}
    for robot in run.counted.robots:
        track = run.counted.of(robot)
        away = np.hypot(track.x - track.x[0], track.y - track.y[0])
        farthest[robot] = float(away.max())
    return Value('excursion', farthest, 'm')
