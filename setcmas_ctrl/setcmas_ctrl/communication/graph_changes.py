"""Changes of a communication graph over time, link by link."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats

Change = tuple[float, int, int, float]


class GraphChanges:
    """Notes the links whose weight changes.

    Attributes:
        rows: Time in s, receiver, sender and new weight of each change.
    """

    def __init__(self, nb_robots: int) -> None:
        """Start without any link."""
        self.rows: list[Change] = []
        self._last: Floats = np.zeros((nb_robots, nb_robots))

    def note(self, t: float, adjacency: Floats) -> bool:
        """Note the graph of a time t (s), shape (N, N); returns whether it is another one."""
        if adjacency is self._last or np.array_equal(adjacency, self._last):
            return False
        for i, j in zip(*np.nonzero(adjacency != self._last), strict=True):
            self.rows.append((t, int(i) + 1, int(j) + 1, float(adjacency[i, j])))
        self._last = adjacency
        return True
