"""Robots go round circles of their own; a file named by SETCMAS_REHEARSAL tells them otherwise."""

import math
import os
import time
from pathlib import Path

MODE = Path(os.environ['SETCMAS_REHEARSAL'])
RADIUS = 0.9
SPEED = 0.5


def control(robotNo, nbRobots, poses, t):
    mode = MODE.read_text() if MODE.exists() else ''
    if mode == 'stuck':
        while True:
            time.sleep(0.1)
    if mode == 'nan':
        return math.nan, math.nan
    x, y, _ = poses[:, robotNo - 1]
    if mode == 'collide':
        other = poses[:2, robotNo % nbRobots]
        return tuple(SPEED * (other - (x, y)) / math.hypot(other[0] - x, other[1] - y))
    centre = 1.5 if robotNo % 2 else -1.5
    dx, dy = x - centre, y
    distance = math.hypot(dx, dy) or 1e-6
    inwards = RADIUS - distance
    return (
        SPEED * (-dy / distance) + inwards * dx / distance,
        SPEED * (dx / distance) + inwards * dy / distance,
    )
