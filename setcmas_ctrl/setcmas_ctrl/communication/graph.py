"""Communication graph of a fleet: presets, files, adjacency and Laplacian, changes over time."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, did_you_mean
from setcmas_simu.option_kinds import Number, OneOf
from setcmas_simu.yaml_entries import Entry, read_entries

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


Graph = str | Path | ArrayLike
"""Name of a preset, graph file or adjacency matrix."""

Build = Callable[[int], Floats]
"""Function from the size of a fleet to the adjacency matrix, or SetcmasError."""

Pairs = list[tuple[int, int]]
"""Numbers of the receiver and the sender of each link."""


def graph_description(graph: Graph) -> GraphDescription:
    """Return the graph of a preset, a file or an adjacency matrix, or raise SetcmasError."""
    if not isinstance(graph, (str, Path)):
        build = partial(checked_adjacency, graph)
        return GraphDescription([('', math.inf, build)])
    path, name = Path(graph), str(graph).replace('-', '_')
    if name in PRESETS:
        return GraphDescription([(name, math.inf, PRESETS[name])])
    if path.suffix not in ('.yaml', '.yml') and not path.is_file():
        known = f'{", ".join(PRESETS)} or a YAML file{did_you_mean(name, PRESETS, 2)}'
        raise SetcmasError(f"unknown graph '{graph}'; it must be {known}")
    return load_graph(path)


@dataclass(frozen=True)
class GraphDescription:
    """Graphs one after the other, for any suitable fleet size.

    Attributes:
        parts: Name, duration in s and adjacency matrix of each.
        repeat: Whether they repeat after the last one.
    """

    parts: list[tuple[str, float, Build]]
    repeat: bool = False

    def segments(self, nb_robots: int) -> list[Segment]:
        """Return the graphs for a fleet.

        Raises:
            SetcmasError: A graph names a robot outside the fleet, or is of another fleet size.
        """
        return [
            Segment(name, duration, checked_adjacency(build(nb_robots), nb_robots))
            for name, duration, build in self.parts
        ]


_LINK = re.compile(r'\s*([1-9]\d{0,3})\s*(-|<-|->)\s*([1-9]\d{0,3})\s*')
_LINK_FORM = (
    "'1 - 2' (both directions), '1 <- 2' (1 receives from 2) or '2 -> 1' (the same), "
    'or with a weight: 1 - 2: 0.5'
)
_GRAPH_KEYS = ('graph', 'edges')

_WEIGHT = Number(least=0, finite=True)
_DURATION = Number(above=0, unit='s', finite=True)


def load_graph(path: Path) -> GraphDescription:
    """Read a graph file (docs/communication.md), or raise SetcmasError with file and line."""
    top = read_entries(path)
    keys = top.fields(('segments', *_GRAPH_KEYS, 'repeat'))
    if 'segments' not in keys:
        if 'repeat' in keys:
            raise keys['repeat'].error("'repeat' needs 'segments'")
        return GraphDescription([('', math.inf, _graph(top, keys))])
    for key in _GRAPH_KEYS:
        if key in keys:
            raise keys[key].error(f"'{key}' belongs in the segments")
    parts = [_segment(entry, k) for k, entry in enumerate(_items(keys['segments']), 1)]
    repeat = 'repeat' in keys and keys['repeat'].flag()
    durations = [duration for _, duration, _ in parts]
    if math.inf in (durations if repeat else durations[:-1]):
        raise keys['segments'].error('every segment except the last needs a duration (s)')
    return GraphDescription(parts, repeat)


def _segment(entry: Entry, number: int) -> tuple[str, float, Build]:
    keys = entry.fields(('name', 'duration', *_GRAPH_KEYS))
    name = keys['name'].text() if 'name' in keys else f'segment {number}'
    duration = _DURATION.of(keys['duration']) if 'duration' in keys else math.inf
    return name, duration, _graph(entry, keys)


def _graph(entry: Entry, keys: dict[str, Entry]) -> Build:
    if ('graph' in keys) == ('edges' in keys):
        what = 'has graph and edges' if 'graph' in keys else 'has no graph'
        raise entry.error(f'{what}; it must be one of {", ".join(_GRAPH_KEYS)}')
    if 'edges' in keys:
        return _edges(keys['edges'])
    return PRESETS[OneOf(tuple(PRESETS)).of(keys['graph'])]


def _edges(entry: Entry) -> Build:
    weights: dict[tuple[int, int], float] = {}
    largest, its_item = 0, entry
    for item in _items(entry):
        pairs, weight = _edge(item)
        for pair in pairs:
            if pair in weights:
                raise item.error(f"'{pair[0]} <- {pair[1]}' appears twice; remove one")
            weights[pair] = weight
        if max(pairs[0]) > largest:
            largest, its_item = max(pairs[0]), item

    def build(nb_robots: int) -> Floats:
        if largest > nb_robots:
            raise its_item.error(
                f'it names robot {largest}; the fleet has robots 1 to {nb_robots}'
            )
        adjacency = np.zeros((nb_robots, nb_robots))
        for (receiver, sender), weight in weights.items():
            adjacency[receiver - 1, sender - 1] = weight
        return adjacency

    return build


def _edge(entry: Entry) -> tuple[Pairs, float]:
    """Return the links of an edge such as `1 - 2` or `1 <- 2: 0.5`, and their weight."""
    if not isinstance(entry.value, dict):
        return _pairs(entry, entry.value), 1.0
    if len(entry.value) != 1:
        raise entry.mistake(_LINK_FORM)
    ((link, weight),) = entry.value.items()
    return _pairs(entry, link), _WEIGHT.of(weight)


def _pairs(entry: Entry, text: object) -> Pairs:
    found = _LINK.fullmatch(text) if isinstance(text, str) else None
    if not found:
        raise entry.mistake(_LINK_FORM)
    first, arrow, second = int(found[1]), found[2], int(found[3])
    if first == second:
        raise entry.error(f"'{text}': robots have no links to themselves")
    both = [(first, second), (second, first)]
    return {'-': both, '<-': both[:1], '->': both[1:]}[arrow]


def _items(entry: Entry) -> list[Entry]:
    if not (items := entry.items()):
        raise entry.mistake('a non-empty list')
    return items
