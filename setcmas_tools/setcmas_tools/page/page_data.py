"""Looks of robots, packed numbers, and the empty content of a page: without matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.palettes import is_bright, plot_colour, plot_hex
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.models_by_name import shape_of, symbol

SCALE = 10_000
"""Units of a packed number per m, rad or s: positions keep a tenth of a millimetre."""

Packed = list[int | None]


def page_content(**known: Any) -> dict[str, Any]:
    """Return the content of a page; parts that are not given are empty."""
    plane: dict[str, Any] = {
        **dict.fromkeys(('arena', 'links')),
        **{name: [] for name in ('discs', 'polygons', 'references', 'drawings')},
        'sent': {},
    }
    empty: dict[str, Any] = {
        **{name: [] for name in ('t', 'robots', 'others', 'charts')},
        **{'scale': SCALE, 'calls': {}, 'plane': plane, 'live': None},
    }
    return empty | known


def look_entry(robot: int, model: str, nb_robots: int) -> dict[str, Any]:
    """Return name, colour and outline of a robot, and the size in m of a unit of the outline."""
    outline = symbol(model)
    true_m = np.ptp(np.array(shape_of(model).outline), axis=0)
    return {
        'number': robot,
        'name': robot_name(robot),
        'colour': plot_hex(robot, nb_robots),
        'bright': is_bright(plot_colour(robot, nb_robots)),
        'outline': np.round(outline, 3).tolist(),
        'metres': round(float(true_m[0] / np.ptp(outline[:, 0])), 4),
    }


def colour_code(colour: Sequence[float]) -> str:
    """Return red, green and blue as a page has them; they are clipped to 0 to 1."""
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in colour)
    return f'#{red:02x}{green:02x}{blue:02x}'


def packed(values: Floats | Sequence[float]) -> Packed:
    """Return K numbers as differences from the last known one, in 1/`SCALE`; None for NaN."""
    numbers = np.asarray(values, dtype=float)
    known = np.flatnonzero(np.isfinite(numbers))
    steps = np.diff(np.round(numbers[known] * SCALE).astype(np.int64), prepend=0).tolist()
    result: Packed = [None] * len(numbers)
    for place, step in zip(known.tolist(), steps, strict=True):
        result[place] = step
    return result


def changes(values: Sequence[object]) -> list[tuple[int, object]]:
    """Return the changes of a column that seldom changes: index and new value of each."""
    return [
        (place, value)
        for place, value in enumerate(values)
        if not place or value != values[place - 1]
    ]
