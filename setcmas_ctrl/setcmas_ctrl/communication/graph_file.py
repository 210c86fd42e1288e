"""Communication graphs in YAML files: presets or edges, switching graphs, imperfect links.

docs/communication.md describes the format.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.communication.graph import PRESETS, Segment, checked_adjacency
from setcmas_ctrl.communication.links import LinkChannel
from setcmas_simu.arrays import Floats
from setcmas_simu.option_kinds import Number, OneOf
from setcmas_simu.yaml_entries import Entry, read_entries

_LINK = re.compile(r'\s*([1-9]\d{0,3})\s*(-|<-|->)\s*([1-9]\d{0,3})\s*')
_LINK_FORM = "'1 - 2' (both directions), '1 <- 2' (1 receives from 2) or '2 -> 1' (the same)"
_GRAPH_KEYS = ('graph', 'edges')

_WEIGHT = Number(least=0, finite=True)
_DURATION = Number(above=0, unit='s', finite=True)
_OF_LINKS = {
    'delay': Number(least=0, unit='s', finite=True),
    'loss': Number(least=0, most=1),
    'noise': Number(least=0, unit='m', finite=True),
}

Build = Callable[[int], Floats]
Pairs = list[tuple[int, int]]


@dataclass(frozen=True)
class GraphDescription:
    """Content of a graph file, for any suitable fleet size.

    Attributes:
        repeat: Whether the segments repeat after the last one.
        links: Links whose properties differ from the others.
    """

    repeat: bool
    links: list[LinkChannel]
    _segments: list[tuple[str, float, Build]]
    _largest: Entry | None = None
    _largest_robot: int = 0

    def segments(self, nb_robots: int) -> list[Segment]:
        """Return the graphs for a fleet.

        Raises:
            SetcmasError: The file names a robot outside the fleet, or a matrix in place of a file
                is not one of this fleet.
        """
        if self._largest and self._largest_robot > nb_robots:
            raise self._largest.error(
                f'it names robot {self._largest_robot}; the fleet has robots 1 to {nb_robots}'
            )
        return [
            Segment(name, duration, checked_adjacency(build(nb_robots), nb_robots))
            for name, duration, build in self._segments
        ]


def load_graph(path: Path) -> GraphDescription:
    """Read a graph file, or raise SetcmasError with file and line."""
    return _Parser().parse(read_entries(path))


class _Parser:
    """Turns the entries of a file into graphs, and finds the largest robot number."""

    def __init__(self) -> None:
        self._largest: Entry | None = None
        self._largest_robot = 0

    def parse(self, top: Entry) -> GraphDescription:
        keys = top.fields(('segments', *_GRAPH_KEYS, 'links', 'repeat'))
        if 'segments' in keys:
            for key in _GRAPH_KEYS:
                if key in keys:
                    raise keys[key].error(f"'{key}' belongs in the segments")
            segments = [
                self._segment(entry, k) for k, entry in enumerate(_items(keys['segments']), 1)
            ]
        else:
            if 'repeat' in keys:
                raise keys['repeat'].error("'repeat' needs 'segments'")
            segments = [('', math.inf, self._graph(top, keys))]
        repeat = 'repeat' in keys and keys['repeat'].flag()
        ends = [duration for _, duration, _ in segments]
        if math.inf in (ends if repeat else ends[:-1]):
            raise keys['segments'].error('every segment except the last needs a duration (s)')
        links = _items(keys['links']) if 'links' in keys else []
        channels = [channel for entry in links for channel in self._channels(entry)]
        return GraphDescription(repeat, channels, segments, self._largest, self._largest_robot)

    def _segment(self, entry: Entry, number: int) -> tuple[str, float, Build]:
        keys = entry.fields(('name', 'duration', *_GRAPH_KEYS))
        name = keys['name'].text() if 'name' in keys else f'segment {number}'
        duration = math.inf
        if 'duration' in keys:
            duration = _DURATION.of(keys['duration'])
        return name, duration, self._graph(entry, keys)

    def _graph(self, entry: Entry, keys: dict[str, Entry]) -> Build:
        if ('graph' in keys) == ('edges' in keys):
            what = 'has graph and edges' if 'graph' in keys else 'has no graph'
            raise entry.error(f'{what}; it must be one of {", ".join(_GRAPH_KEYS)}')
        if 'edges' in keys:
            return self._edges(keys['edges'])
        return PRESETS[OneOf(tuple(PRESETS)).of(keys['graph'])]

    def _edges(self, entry: Entry) -> Build:
        weights: dict[tuple[int, int], float] = {}
        for item in _items(entry):
            pairs, weight = self._edge(item)
            for receiver, sender in pairs:
                if (receiver, sender) in weights:
                    raise item.error(f"'{receiver} <- {sender}' appears twice; remove one")
                weights[receiver, sender] = weight

        def build(nb_robots: int) -> Floats:
            adjacency = np.zeros((nb_robots, nb_robots))
            for (receiver, sender), weight in weights.items():
                adjacency[receiver - 1, sender - 1] = weight
            return adjacency

        return build

    def _edge(self, entry: Entry) -> tuple[Pairs, float]:
        """Return the pairs (receiver, sender) of an edge such as `1 - 2` or `1 <- 2: 0.5`."""
        if not isinstance(entry.value, dict):
            return self._pairs(entry, entry.value), 1.0
        if len(entry.value) != 1:
            raise entry.mistake(f'{_LINK_FORM}, or with a weight: 1 - 2: 0.5')
        ((link, weight),) = entry.value.items()
        return self._pairs(entry, link), _WEIGHT.of(weight)

    def _pairs(self, entry: Entry, text: object) -> Pairs:
        found = _LINK.fullmatch(text) if isinstance(text, str) else None
        if not found:
            raise entry.mistake(_LINK_FORM)
        first, arrow, second = int(found[1]), found[2], int(found[3])
        if first == second:
            raise entry.error(f"'{text}': robots have no links to themselves")
        if max(first, second) > self._largest_robot:
            self._largest, self._largest_robot = entry, max(first, second)
        both = [(first, second), (second, first)]
        return {'-': both, '<-': both[:1], '->': both[1:]}[arrow]

    def _channels(self, entry: Entry) -> list[LinkChannel]:
        keys = entry.fields(('link', 'delay', 'loss', 'noise'))
        if 'link' not in keys:
            raise entry.error(f"'link' is missing; it must be {_LINK_FORM}")
        values: dict[str, Any] = {
            name: kind.of(keys[name]) for name, kind in _OF_LINKS.items() if name in keys
        }
        return [
            replace(LinkChannel(receiver, sender), **values)
            for receiver, sender in self._pairs(keys['link'], keys['link'].value)
        ]


def _items(entry: Entry) -> list[Entry]:
    if not (items := entry.items()):
        raise entry.mistake('a non-empty list')
    return items
