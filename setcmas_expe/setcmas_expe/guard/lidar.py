"""Lidar of a robot: what stands in its way, as Nav2's collision monitor finds it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

BESIDE_WHEELS_M = 0.04
"""How far (m) the strip in which a robot moves reaches beyond the middle of its wheels."""

FRONT_M = 0.14
"""Largest distance in m from a TurtleBot3's lidar to its front: a Waffle's; a Burger's is 0.07."""

MARGIN_M = 0.05
"""Distance in m that is left to what a robot has stopped for."""

REACTION_S = 0.4
"""Longest time in s until a robot brakes: a turn of the lidar, at 5 Hz, and its transmission."""

BRAKING_M_S2 = 2.5
"""Deceleration in m/s^2 with which ROBOTIS' navigation stack brakes a Burger
(turtlebot3_navigation2, param/burger.yaml)."""

SILENT_AFTER_S = REACTION_S
"""Silence in s after which a lidar counts as dead: the braking distance allows for no more."""

_FEWEST_POINTS = 3  # a single one may be dust
_NEAREST_M = 1e-3  # stands for what is too near to be measured


def braking_distance(V: float) -> float:
    """Return how far (m) from its lidar a robot at V (m/s) must find its way free."""
    return FRONT_M + MARGIN_M + abs(V) * REACTION_S + V * V / (2.0 * BRAKING_M_S2)


def clearance(
    ranges: Sequence[float], first: float, step: float, V: float, wheel_separation: float
) -> float:
    """Return the distance (m) of the nearest thing in the way of a robot; inf if there is none.

    It is NaN if the lidar sees nothing, near or far: it may be covered.

    Args:
        ranges: Distances in m of a scan; inf where nothing is in its range, -inf where something
            is nearer than that (REP 117). NaN and what is not positive measure nothing.
        first: Angle of the first of them in rad, from straight ahead to the left.
        step: Angle between two of them in rad.
        V: Forward speed in m/s; backwards if negative. A robot that only turns meets nothing.
        wheel_separation: Distance in m between its wheels.
    """
    distances = np.array(ranges, dtype=float)
    too_near = np.isneginf(distances)
    last = first + step * len(distances)
    if not math.isfinite(last) or not (too_near | (distances > 0.0)).any():
        return math.nan
    angles = first + step * np.arange(len(distances))
    distances[too_near] = _NEAREST_M
    seen = np.isfinite(distances) & (distances > 0.0)
    ahead = math.copysign(1.0, V) * distances[seen] * np.cos(angles[seen])
    beside = np.abs(distances[seen] * np.sin(angles[seen]))
    is_in_the_way = beside <= 0.5 * wheel_separation + BESIDE_WHEELS_M
    found = np.sort(ahead[is_in_the_way & (ahead > 0.0)])
    if V == 0.0 or len(found) < _FEWEST_POINTS:
        return math.inf
    return float(found[_FEWEST_POINTS - 1])
