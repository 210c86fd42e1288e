"""Colours and dashes of robots' lines in plots."""

from __future__ import annotations

from typing import Any

from matplotlib import colormaps
from matplotlib.colors import to_rgb

from setcmas_simu.fleet import fleet
from setcmas_simu.fleet.fleet import Colour

# M. Okabe and K. Ito, Color Universal Design, 2008; first those that differ most on white paper.
_OKABE_ITO: tuple[Colour, ...] = tuple(
    to_rgb(colour)
    for colour in (
        '#0072B2',  # blue
        '#D55E00',  # vermillion
        '#009E73',  # bluish green
        '#CC79A7',  # reddish purple
        '#E69F00',  # orange
        '#56B4E9',  # sky blue
        '#000000',  # black
        '#F0E442',  # yellow
    )
)
_DASHES: tuple[Any, ...] = ('solid', (0, (4, 1.6)))
_MOST_COLOURS = len(_OKABE_ITO) * len(_DASHES)
# J. R. Nuñez, C. R. Anderton, R. S. Renslow, PLOS ONE 13(7), 2018: the same for all readers.
_SCALE, _BRIGHTEST = colormaps['cividis'], 0.77
_SAMPLES = 5
"""Robots that stand for a whole fleet in a legend where colours go on evenly."""


def is_scale(palette: str, nb_robots: int) -> bool:
    """Return whether colours go on evenly with the robots' numbers: too many for distinct ones."""
    return palette != 'robots' and nb_robots > _MOST_COLOURS


def robot_colour(palette: str, robot: int, nb_robots: int) -> Colour:
    """Return the colour of a robot in a fleet of nb_robots on white paper."""
    if palette == 'robots':
        return fleet.plot_colour(robot)
    if is_scale(palette, nb_robots):
        place = (robot - 1) % nb_robots / (nb_robots - 1)
        return to_rgb(_SCALE(_BRIGHTEST * place))
    return _OKABE_ITO[(robot - 1) % len(_OKABE_ITO)]


def robot_dashes(palette: str, robot: int, nb_robots: int) -> Any:
    """Return the line style of a robot; it tells robots of one colour apart."""
    if palette == 'robots' or is_scale(palette, nb_robots):
        return 'solid'
    return _DASHES[(robot - 1) // len(_OKABE_ITO) % len(_DASHES)]


def is_shared(palette: str, robot: int) -> bool:
    """Return whether the robot has the colour of all those without a colour of their own."""
    return palette == 'robots' and fleet.plot_colour(robot) == fleet.plot_colour(10_000)


def legend_robots(palette: str, robots: list[int]) -> list[int]:
    """Return the robots that get a legend entry each; all, or some where colours go on evenly."""
    distinct = [robot for robot in robots if not is_shared(palette, robot)]
    if not is_scale(palette, len(robots)):
        return distinct
    last = len(robots) - 1
    return [robots[round(i * last / (_SAMPLES - 1))] for i in range(_SAMPLES)]
