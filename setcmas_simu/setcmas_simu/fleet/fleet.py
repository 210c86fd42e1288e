"""Fleet tb3_1 .. tb3_N: numbers and default start poses of its robots."""

from __future__ import annotations

import math
import re

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

_START_POSES_OF_8 = 5.0 * np.array(
    [[1, 1, -1, -1, 0, 1, 0, -1], [1, -1, -1, 1, 1, 0, -1, 0]]  # m
)
_FIRST_RING_RADIUS = 8.5  # m: more than 1 m outside the corners of the square of the first 8
_RING_SPACING = 1.25  # m, between rings and at least between neighbours on a ring


def start_poses(nb_robots: int) -> Floats:
    """Return the default start poses of a fleet: x, y in m and theta in rad, shape (3, nb_robots).

    One robot starts at the origin, several on the border of a 10 m square as in ROS 1, further
    ones on rings around it that keep 1 m between robots. All headings are 0.
    """
    poses = np.zeros((3, nb_robots))
    if nb_robots == 1:
        return poses
    places = list(_START_POSES_OF_8.T)
    radius = _FIRST_RING_RADIUS
    while len(places) < nb_robots:
        # The chord between neighbours is a little shorter than the arc, hence the spacing > 1 m.
        nb_on_ring = int(2 * math.pi * radius / _RING_SPACING)
        angles = 2 * math.pi * np.arange(nb_on_ring) / nb_on_ring
        places.extend(zip(radius * np.cos(angles), radius * np.sin(angles), strict=True))
        radius += _RING_SPACING
    poses[:2] = np.array(places[:nb_robots]).T
    return poses


def parse_robots(text: str) -> list[int]:
    """Return the sorted numbers in a text such as '1-4' or '2,5-7', or raise SetcmasError."""
    robots: set[int] = set()
    for part in text.split(','):
        found = re.fullmatch(r'\s*([1-9][0-9]{0,3})\s*(?:-\s*([1-9][0-9]{0,3}))?\s*', part)
        if not found or int(found[2] or found[1]) < int(found[1]):
            raise SetcmasError(
                f"invalid robots '{text}'; must be numbers from 1 and ranges, "
                "such as '1-4' or '2,5-7'"
            )
        robots.update(range(int(found[1]), int(found[2] or found[1]) + 1))
    return sorted(robots)


def robots_in_words(robots: list[int], verb: str = '') -> str:
    """Return 'robot 2' or 'robots 1-3' for sorted numbers, and a verb: 'are' or 'have'."""
    if len(robots) == 1:
        verb = {'are': 'is', 'have': 'has'}.get(verb, verb)
    plural = 's' if len(robots) != 1 else ''
    return f'robot{plural} {format_robots(robots)} {verb}'.rstrip()


def format_robots(robots: list[int]) -> str:
    """Return the shortest text that `parse_robots` turns into these sorted robot numbers."""
    runs: list[list[int]] = []
    for robot in robots:
        if runs and robot == runs[-1][-1] + 1:
            runs[-1].append(robot)
        else:
            runs.append([robot])
    return ','.join(f'{run[0]}-{run[-1]}' if len(run) > 1 else f'{run[0]}' for run in runs)
