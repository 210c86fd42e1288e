"""Distance between the shapes of two formations, whichever robot has which place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats

Points = NDArray[np.complex128]

_MOST_STEPS = 20
_POINT_M = 1e-9


def shape_distance(places: Floats, wanted: Floats) -> float:
    """Return the RMS distance of robots to the places of a formation in m.

    The formation is moved, turned and its places are assigned to robots so that the distance is
    least: least squares (Umeyama 1991) and assignment in turns, from each turn that brings its
    outermost place in line with a robot. Mirrored formations differ.

    Args:
        places: Positions in m, shape (N, 2).
        wanted: Positions of the formation in m, shape (N, 2).
    """
    robots, formation = (_centred(one) for one in (places, wanted))
    outermost = formation[np.argmax(np.abs(formation))]
    if abs(outermost) < _POINT_M:
        return float(np.sqrt(np.mean(np.abs(robots) ** 2)))
    return min(_distance_from(robots, formation, robot / outermost) for robot in robots)


def _centred(places: Floats) -> Points:
    points = places[:, 0] + 1j * places[:, 1]
    return np.asarray(points - points.mean(), dtype=np.complex128)


def _distance_from(
    robots: Points,
    formation: Points,
    turn: complex,
) -> float:
    """Return the least distance that is found from a first turn, a complex number."""
    before: list[int] = []
    for _ in range(_MOST_STEPS):
        turn = turn / abs(turn) if abs(turn) else 1.0 + 0.0j
        costs = np.abs(robots[:, None] - turn * formation[None, :]) ** 2
        places = assignment(costs).tolist()
        if places == before:
            break
        before = places
        turn = complex(np.vdot(formation[places], robots))
    return float(np.sqrt(np.mean(costs[np.arange(len(places)), places])))


def assignment(costs: Floats) -> NDArray[np.intp]:
    """Return a column for each row, each once, with the least sum of costs, shape (N, N).

    Shortest augmenting paths (Jonker and Volgenant 1987). scipy has the same, but is not among
    the packages that every installation has.
    """
    n = len(costs)
    of_row, of_column = np.zeros(n + 1), np.zeros(n + 1)  # prices; column 0 is a start
    row_of = np.zeros(n + 1, dtype=int)
    for row in range(1, n + 1):
        row_of[0], column = row, 0
        least, previous = np.full(n + 1, np.inf), np.zeros(n + 1, dtype=int)
        is_used = np.zeros(n + 1, dtype=bool)
        while row_of[column]:
            is_used[column] = True
            own = row_of[column]
            reduced = np.append(np.inf, costs[own - 1] - of_row[own] - of_column[1:])
            is_less = ~is_used & (reduced < least)
            least[is_less], previous[is_less] = reduced[is_less], column
            column = int(np.argmin(np.where(is_used, np.inf, least)))
            step = least[column]
            of_row[row_of[is_used]] += step
            of_column[is_used] -= step
            least[~is_used] -= step
        while column:
            row_of[column], column = row_of[previous[column]], int(previous[column])
    columns = np.empty(n, dtype=int)
    columns[row_of[1:] - 1] = np.arange(n)
    return columns
