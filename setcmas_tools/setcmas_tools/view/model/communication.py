"""Links between robots as lines, and the flash of a robot that has just communicated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats

Pairs = NDArray[np.int64]

FLASH_S = 0.5


def links(weights: Floats) -> tuple[Pairs, Pairs]:
    """Return the links of a communication graph.

    Args:
        weights: Entry [i, j] > 0 if robot i + 1 hears robot j + 1, shape (N, N).

    Returns:
        Robot numbers of the links that go both ways, each once, shape (E, 2); and of those
        that go one way only, sender first, shape (F, 2).
    """
    hears = np.nan_to_num(weights) > 0
    np.fill_diagonal(hears, False)
    both = np.argwhere(np.triu(hears & hears.T))
    one_way = np.argwhere(hears & ~hears.T)[:, ::-1]
    return both + 1, one_way + 1


def matrix(sizes: list[int], data: list[float]) -> Floats | None:
    """Return the N x N matrix of a message; None if its parts do not fit together."""
    if len(sizes) != 2 or sizes[0] != sizes[1] or len(data) != sizes[0] * sizes[1]:
        return None
    return np.array(data, dtype=float).reshape(sizes)


class Flashes:
    """The robots that have communicated within the last moment."""

    def __init__(self) -> None:
        """Start in the dark."""
        self._times: dict[int, float] = {}

    def trigger(self, robot: int, now: float) -> None:
        """Note that a robot communicated."""
        self._times[robot] = now

    def strength(self, robots: list[int], now: float) -> Floats:
        """Return for each robot how bright its flash is: 1 at first, 0 after `FLASH_S`."""
        ages = np.array([now - self._times.get(robot, -np.inf) for robot in robots])
        result: Floats = np.clip(1.0 - ages / FLASH_S, 0.0, 1.0)
        return result
