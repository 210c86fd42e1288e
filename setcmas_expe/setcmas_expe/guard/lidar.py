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

SILENT_AFTER_S = 1.0
"""Silence in s after which a lidar counts as dead."""

_FEWEST_POINTS = 3  # a single one may be dust


def braking_distance(V: float) -> float:
    """Return how far (m) from its lidar a robot at V (m/s) must find its way free."""
    return FRONT_M + MARGIN_M + abs(V) * REACTION_S + V * V / (2.0 * BRAKING_M_S2)


def clearance(
    ranges: Sequence[float], first: float, step: float, V: float, wheel_separation: float
) -> float:
    """Return the distance (m) of the nearest thing in the way of a robot; inf if there is none.

    Args:
        ranges: Distances in m of a scan; those that are not finite and positive are left out.
        first: Angle of the first of them in rad, from straight ahead to the left.
        step: Angle between two of them in rad.
        V: Forward speed in m/s; backwards if negative. A robot that only turns meets nothing.
        wheel_separation: Distance in m between its wheels.
    """
    distances = np.asarray(ranges, dtype=float)
    angles = first + step * np.arange(len(distances))
    seen = np.isfinite(distances) & (distances > 0.0)
    ahead = math.copysign(1.0, V) * distances[seen] * np.cos(angles[seen])
    beside = np.abs(distances[seen] * np.sin(angles[seen]))
    is_in_the_way = beside <= 0.5 * wheel_separation + BESIDE_WHEELS_M
    found = np.sort(ahead[is_in_the_way & (ahead > 0.0)])
    if V == 0.0 or len(found) < _FEWEST_POINTS:
        return math.inf
    return float(found[_FEWEST_POINTS - 1])
