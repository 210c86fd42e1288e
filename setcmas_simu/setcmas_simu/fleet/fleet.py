"""Fleet tb3_1 .. tb3_N: numbers, colours and start poses of its robots, and /fleet."""

from __future__ import annotations

import math
import re
from contextvars import ContextVar

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

Colour = tuple[float, float, float]

_START_POSES_OF_8 = 5.0 * np.array(
    [[1, 1, -1, -1, 0, 1, 0, -1], [1, -1, -1, 1, 1, 0, -1, 0]]  # m
)
_FIRST_RING_RADIUS = 8.5  # m: more than 1 m outside the corners of the square of the first 8
_RING_SPACING = 1.25  # m, between rings and at least between neighbours on a ring

PALETTES = ('okabe-ito', 'ros1')
"""Colours for colour-blind readers, or those of the ROS 1 stack."""

palette: ContextVar[str] = ContextVar('palette', default=PALETTES[0])
"""The palette in use, one of `PALETTES`."""

# M. Okabe and K. Ito, Color Universal Design, 2008; the most distinct on white paper first.
_OKABE_ITO: tuple[Colour, ...] = (
    (0.0, 0.447, 0.698),  # blue
    (0.835, 0.369, 0.0),  # vermillion
    (0.0, 0.62, 0.451),  # bluish green
    (0.8, 0.475, 0.655),  # reddish purple
    (0.902, 0.624, 0.0),  # orange
    (0.337, 0.706, 0.914),  # sky blue
    (0.0, 0.0, 0.0),  # black
    (0.941, 0.894, 0.259),  # yellow
)
# J. R. Nuñez, C. R. Anderton, R. S. Renslow, PLOS ONE 13(7), 2018: cividis without its brightest.
_SCALE = (
    (0.0, 0.135, 0.305),
    (0.149, 0.24, 0.431),
    (0.317, 0.346, 0.426),
    (0.455, 0.457, 0.459),
    (0.597, 0.571, 0.466),
    (0.757, 0.697, 0.415),
)
_ROS1: tuple[Colour, ...] = (
    (1.0, 0.0, 0.0),  # red
    (0.0, 1.0, 0.0),  # green
    (0.0, 0.0, 1.0),  # blue
    (1.0, 0.91, 0.31),  # yellow
    (1.0, 1.0, 1.0),  # white
    (0.96, 0.18, 0.92),  # magenta
    (1.0, 0.49, 0.37),  # salmon
    (0.0, 0.0, 0.0),  # black
)
NB_COLOURS = len(_OKABE_ITO)
_MOST_DISTINCT = 2 * NB_COLOURS  # in two line styles
_GREY: Colour = (0.5, 0.5, 0.5)
_WHITE: Colour = (1.0, 1.0, 1.0)
_LIGHT_GREY: Colour = (0.78, 0.78, 0.78)
_BRIGHT = 0.7


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


def colour(robot: int) -> Colour:
    """Return the colour of a robot as (red, green, blue), each in [0, 1], from its number."""
    if palette.get() == 'ros1':
        return _ROS1[robot - 1] if robot <= len(_ROS1) else _GREY
    return _OKABE_ITO[(robot - 1) % NB_COLOURS]


def plot_colour(robot: int, nb_robots: int = 1) -> Colour:
    """Return the colour of a robot in a fleet of nb_robots on white paper.

    The white robot is light grey there, and a large fleet has a continuous scale of colours.
    """
    if is_scale(nb_robots):
        place = (robot - 1) % nb_robots / (nb_robots - 1) * (len(_SCALE) - 1)
        low = min(int(place), len(_SCALE) - 2)
        both = zip(_SCALE[low], _SCALE[low + 1], strict=True)
        red, green, blue = (a + (place - low) * (b - a) for a, b in both)
        return red, green, blue
    own = colour(robot)
    return _LIGHT_GREY if own == _WHITE else own


def is_scale(nb_robots: int) -> bool:
    """Return whether a fleet has a continuous scale: too many robots for distinct colours."""
    return palette.get() != 'ros1' and nb_robots > _MOST_DISTINCT


def is_bright(colour: Colour) -> bool:
    """Return whether a colour needs a dark edge on white paper, by its luminance."""
    red, green, blue = colour
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue >= _BRIGHT


def plot_hex(robot: int, nb_robots: int = 1) -> str:
    """Return the colour of a robot on white paper as hexadecimal text, such as '#0072b2'."""
    return '#' + ''.join(f'{round(255 * part):02x}' for part in plot_colour(robot, nb_robots))


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
