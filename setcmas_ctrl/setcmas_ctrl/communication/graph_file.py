"""Communication graphs in YAML files: a preset or edges, or several graphs one after the other.

docs/communication.md describes the format.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from setcmas_ctrl.communication.graph import PRESETS, Segment, checked_adjacency
from setcmas_simu.arrays import Floats
from setcmas_simu.option_kinds import Number, OneOf
from setcmas_simu.yaml_entries import Entry, read_entries

_LINK = re.compile(r'\s*([1-9]\d{0,3})\s*(-|<-|->)\s*([1-9]\d{0,3})\s*')
_LINK_FORM = "'1 - 2' (both directions), '1 <- 2' (1 receives from 2) or '2 -> 1' (the same)"
_GRAPH_KEYS = ('graph', 'edges')

_WEIGHT = Number(least=0, finite=True)
_DURATION = Number(above=0, unit='s', finite=True)

Build = Callable[[int], Floats]
"""Function from the size of a fleet to the adjacency matrix, or SetcmasError."""

Pairs = list[tuple[int, int]]
"""Numbers of the receiver and the sender of each link."""


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


def load_graph(path: Path) -> GraphDescription:
    """Read a graph file, or raise SetcmasError with file and line."""
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
        raise entry.mistake(f'{_LINK_FORM}, or with a weight: 1 - 2: 0.5')
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
