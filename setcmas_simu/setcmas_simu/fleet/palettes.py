"""Colours of robots, which colour-blind readers can tell apart, on screens and on white paper."""

from __future__ import annotations

Colour = tuple[float, float, float]

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
NB_COLOURS = len(_OKABE_ITO)
_MOST_DISTINCT = 2 * NB_COLOURS  # in two line styles
_BRIGHT = 0.7


def colour(robot: int) -> Colour:
    """Return the colour of a robot as (red, green, blue), each in [0, 1], from its number."""
    return _OKABE_ITO[(robot - 1) % NB_COLOURS]


def plot_colour(robot: int, nb_robots: int = 1) -> Colour:
    """Return the colour of a robot in plots; a large fleet has a continuous scale of colours."""
    if not is_scale(nb_robots):
        return colour(robot)
    place = (robot - 1) % nb_robots / (nb_robots - 1) * (len(_SCALE) - 1)
    low = min(int(place), len(_SCALE) - 2)
    both = zip(_SCALE[low], _SCALE[low + 1], strict=True)
    red, green, blue = (a + (place - low) * (b - a) for a, b in both)
    return red, green, blue


def is_scale(nb_robots: int) -> bool:
    """Return whether a fleet has a continuous scale: too many robots for distinct colours."""
    return nb_robots > _MOST_DISTINCT


def is_bright(colour: Colour) -> bool:
    """Return whether a colour needs a dark edge on white paper, by its luminance."""
    red, green, blue = colour
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue >= _BRIGHT


def plot_hex(robot: int, nb_robots: int = 1) -> str:
    """Return the colour of a robot on white paper as hexadecimal text, such as '#0072b2'."""
    return '#' + ''.join(f'{round(255 * part):02x}' for part in plot_colour(robot, nb_robots))
