"""Robots go round circles where they are; a file named by SETCMAS_REHEARSAL tells otherwise."""

import math
import os
import sys
import time
from pathlib import Path

MODE = Path(os.environ['SETCMAS_REHEARSAL'])
RADIUS = 0.5
SPEED = 0.5

FAILURES = {
    'slow': lambda: time.sleep(1.0),
    'nan': lambda: (math.nan, math.nan),
    'inf': lambda: (math.inf, 0.0),
    'none': lambda: None,
    'three': lambda: (0.1, 0.1, 0.1),
    'raise': lambda: 1 / 0,
    'exit': sys.exit,
    'kill': lambda: os._exit(1),
}

centre = None


def control(robotNo, nbRobots, poses, t):
    global centre
    mode = MODE.read_text() if MODE.exists() else ''
    if mode == 'stuck':
        while True:
            time.sleep(0.1)
    if mode in FAILURES:
        return FAILURES[mode]()
    x, y, _ = poses[:, robotNo - 1]
    if mode == 'collide':
        other = poses[:2, robotNo % nbRobots]
        return tuple(SPEED * (other - (x, y)) / math.hypot(other[0] - x, other[1] - y))
    if centre is None:  # towards the middle of the arena
        shrink = max(0.0, 1 - RADIUS / max(math.hypot(x, y), 1e-6))
        centre = x * shrink, y * shrink
    dx, dy = x - centre[0], y - centre[1]
    distance = math.hypot(dx, dy) or 1e-6
    inwards = RADIUS - distance
    return (
        SPEED * (-dy / distance) + inwards * dx / distance,
        SPEED * (dx / distance) + inwards * dy / distance,
    )
