"""Fleet tb3_1 .. tb3_N: numbers and default start poses of its robots."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

_RANGE = r'\d+(?:-\d+)?'
_ROBOTS = rf'\s*({_RANGE}(?:\s*,\s*{_RANGE})*)\s*:'
_ENTRY = re.compile(rf'{_ROBOTS}(.*?)(?:,(?={_ROBOTS})|$)', re.DOTALL)


def is_per_robot(text: str) -> bool:
    """Return whether a text gives values per robot: it begins with robots and a colon.

    For a file whose own name begins like this, users type './1:name.py'.
    """
    return re.match(_ROBOTS, text) is not None


def parse_per_robot(text: str, option: str) -> dict[int, str]:
    """Return the value of each robot in a text such as '1:a,2-4:b' or '1,3:a,2:b'.

    A comma separates two values only if robots and a colon follow it; any other comma or colon
    is part of a value. Raises SetcmasError for other texts, with the name of the option.
    """
    values: dict[int, str] = {}
    for entry in _ENTRY.finditer(text):
        robots, value = entry[1], entry[2]
        if not value.strip():
            raise SetcmasError(
                f"{option} '{text}': '{robots}:' has no value; it must be ROBOTS:VALUE, "
                "such as '1:a,2-4:b'"
            )
        for robot in parse_robots(robots):
            if robot in values:
                raise SetcmasError(f"{option} '{text}' names robot {robot} twice")
            values[robot] = value.strip()
    return values


def format_per_robot(values: Mapping[int, str]) -> str:
    """Return the shortest text that `parse_per_robot` turns into these values."""
    robots_of: dict[str, list[int]] = {}
    for robot in sorted(values):
        robots_of.setdefault(values[robot], []).append(robot)
    return ','.join(f'{format_robots(robots)}:{value}' for value, robots in robots_of.items())


def mapped(text: str, change: Callable[[str], str], option: str) -> str:
    """Return a text with each value changed, whether it has values per robot or just one."""
    if not is_per_robot(text):
        return change(text)
    values = parse_per_robot(text, option)
    return format_per_robot({robot: change(value) for robot, value in values.items()})


def check_in_fleet(robots: Iterable[int], nb_robots: int, option: str) -> None:
    """Raise SetcmasError if an option names a robot outside the fleet."""
    if strangers := sorted(robot for robot in robots if not 1 <= robot <= nb_robots):
        raise SetcmasError(
            f'{option} names robot {strangers[0]}; the fleet has robots 1 to {nb_robots}'
        )


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
