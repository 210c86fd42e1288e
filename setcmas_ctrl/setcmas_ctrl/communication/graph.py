"""Communication graph of a fleet: presets, adjacency and Laplacian, changes over time."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

COMPLETE = 'complete'

_SAME_TIME_S = 1e-9


@lru_cache(maxsize=8)
def complete(nb_robots: int) -> Floats:
    """Return the adjacency matrix of the complete graph; it is read-only."""
    return _read_only(1.0 - np.eye(nb_robots))


def directed_ring(nb_robots: int) -> Floats:
    """Return the adjacency matrix of a directed ring: robot i receives from i + 1."""
    ahead: Floats = np.roll(np.eye(nb_robots), 1, axis=1)
    np.fill_diagonal(ahead, 0.0)  # for a single robot
    return ahead


def ring(nb_robots: int) -> Floats:
    """Return the adjacency matrix of an undirected ring."""
    ahead = directed_ring(nb_robots)
    both: Floats = np.maximum(ahead, ahead.T)
    return both


def path(nb_robots: int) -> Floats:
    """Return the adjacency matrix of a ring without the link between the last and first robot."""
    return np.eye(nb_robots, k=1) + np.eye(nb_robots, k=-1)


def star(nb_robots: int) -> Floats:
    """Return the adjacency matrix of a star with robot 1 in its centre."""
    adjacency = np.zeros((nb_robots, nb_robots))
    adjacency[0, 1:] = adjacency[1:, 0] = 1.0
    return adjacency


PRESETS: dict[str, Callable[[int], Floats]] = {
    COMPLETE: complete,
    'ring': ring,
    'path': path,
    'star': star,
    'directed_ring': directed_ring,
}
"""Preset graphs by name: functions from number of robots to adjacency matrix."""


def checked_adjacency(matrix: ArrayLike, nb_robots: int) -> Floats:
    """Check a matrix of weights and return it as a read-only array of shape (N, N).

    Raises:
        SetcmasError: The matrix has the wrong shape, a weight that is negative or not finite, or
            a diagonal that is not 0.
    """
    try:
        adjacency = np.array(matrix, dtype=float)
    except (TypeError, ValueError) as error:
        raise SetcmasError(f'the adjacency matrix is not a square of numbers: {error}') from error
    if adjacency.shape != (nb_robots, nb_robots):
        raise SetcmasError(
            f'the adjacency matrix has shape {adjacency.shape}; '
            f'the fleet of {nb_robots} needs ({nb_robots}, {nb_robots})'
        )
    if not (np.isfinite(adjacency) & (adjacency >= 0)).all():
        raise SetcmasError('weights of the adjacency matrix must be finite and not negative')
    if adjacency.diagonal().any():
        raise SetcmasError(
            'the diagonal of the adjacency matrix must be 0: robots have no links to themselves'
        )
    return _read_only(adjacency)


def with_known_rows(weights: Floats, adjacency: Floats) -> Floats:
    """Update an adjacency matrix (N, N) with weights that a controller process has published.

    Weights are NaN in the rows of other processes' robots.
    """
    return np.where(np.isnan(weights), adjacency, weights)


def neighbours(adjacency: Floats, robot: int) -> list[int]:
    """Return the sorted numbers of a robot's neighbours, from which it receives."""
    return [int(index) + 1 for index in np.flatnonzero(adjacency[robot - 1])]


def laplacian(adjacency: Floats) -> Floats:
    """Return L = diag(sum_j a_ij) - A, whose rows sum to 0.

    Source: Olfati-Saber and Murray, IEEE Transactions on Automatic Control 49(9), 2004.

    Args:
        adjacency: Weights, shape (N, N); a_ij is the weight that robot i gives robot j.
    """
    return np.diag(adjacency.sum(axis=1)) - adjacency


def reachable(adjacency: ArrayLike) -> NDArray[np.bool_]:
    """Return whether row i receives from column j, itself or through others, shape (N, N)."""
    links = np.asarray(adjacency) != 0
    reached: NDArray[np.bool_] = links | np.eye(len(links), dtype=bool)
    for _ in range(len(links).bit_length()):  # each doubles the number of links on the way
        reached = reached @ reached
    return reached


@dataclass(frozen=True)
class Segment:
    """A graph for a part of the run: name, duration in s, adjacency matrix (N, N)."""

    name: str
    duration: float
    adjacency: Floats


class CommunicationGraph:
    """Graph as a function of time: one graph per segment, with links up to a range.

    Attributes:
        nb_robots: Number of robots.
    """

    def __init__(
        self, segments: Sequence[Segment], repeat: bool = False, reach: float = math.inf
    ) -> None:
        """Set the segments from t = 0; the last one stays, or all repeat. The reach is in m."""
        self._segments = segments
        self.nb_robots = len(segments[0].adjacency)
        self._reach = reach
        ends = np.cumsum([segment.duration for segment in segments])
        self._begins = [0.0, *ends[:-1].tolist()]
        self._period = float(ends[-1]) if repeat else math.inf

    @property
    def is_complete(self) -> bool:
        """Whether the graph is complete, with weights 1, at all times."""
        matrix = complete(self.nb_robots)
        same = all(np.array_equal(part.adjacency, matrix) for part in self._segments)
        return same and not self.needs_places

    @property
    def needs_places(self) -> bool:
        """Whether the graph depends on the robots' positions."""
        return self._reach < math.inf

    def segment(self, t: float) -> Segment:
        """Return the segment at time t in s."""
        if self._period < math.inf:
            t = math.fmod(t + _SAME_TIME_S, self._period)
        return self._segments[max(0, bisect_right(self._begins, t + _SAME_TIME_S) - 1)]

    def adjacency(self, t: float, positions: Floats) -> Floats:
        """Return the weight that each robot (row) gives each other robot (column).

        Args:
            t: Time since the run started, in s.
            positions: Rows x, y in m, shape (2, N); a robot with NaN, whose position is unknown,
                is out of range.

        Returns:
            A read-only array of shape (N, N), the same object while nothing changes.
        """
        adjacency = self.segment(t).adjacency
        if not self.needs_places:
            return adjacency
        x, y = positions
        near = np.hypot(x[:, None] - x, y[:, None] - y) <= self._reach
        return _read_only(np.where(near, adjacency, 0.0))


def _read_only(array: Floats) -> Floats:
    array.setflags(write=False)
    return array


Change = tuple[float, int, int, float]


class GraphChanges:
    """Records the links whose weight changes.

    Attributes:
        rows: Time in s, receiver, sender and new weight of each change.
    """

    def __init__(self, nb_robots: int) -> None:
        self.rows: list[Change] = []
        self._last: Floats = np.zeros((nb_robots, nb_robots))

    def note(self, t: float, adjacency: Floats) -> bool:
        """Record the graph at a time t (s), shape (N, N); return whether it has changed."""
        if adjacency is self._last or np.array_equal(adjacency, self._last):
            return False
        for i, j in zip(*np.nonzero(adjacency != self._last), strict=True):
            self.rows.append((t, int(i) + 1, int(j) + 1, float(adjacency[i, j])))
        self._last = adjacency
        return True
