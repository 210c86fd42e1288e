"""Conditions of a run, and theorems, which hold unless a run departs from their assumptions."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from setcmas_ctrl.communication import graph
from setcmas_simu.arrays import Floats


class Departure(Enum):
    """What a run has, and points that follow their law without limits have not."""

    TURNING = 'turning before driving'
    OWN_TURNING = 'a si_to_uni of its own'
    SPEED_LIMIT = 'the speed limit'
    REST = 'robots at rest'
    FILTER = 'the safety filter'
    CHANGES = 'changes of the graph'
    LOSS = 'lost messages'
    DELAY = 'delay of messages'
    NOISE = 'noise of messages'
    EVENTS = 'event-triggered communication'
    OWN_EXACT = 'own positions that are not held as last sent'
    OWN_CONDITION = 'a triggering condition of its own'
    RATES = 'states and calls at different rates'


class Theorem(NamedTuple):
    """A predicted figure.

    Attributes:
        metric: The metric that measures it, such as 'consensus.convergence_rate_1_s'.
        value: Its value, in the unit of the metric.
        formula: Where it comes from, such as 'lambda_2 of K L'.
        excludes: What a run must not have.
    """

    metric: str
    value: float
    formula: str
    excludes: frozenset[Departure] = frozenset({Departure.CHANGES})


@dataclass(frozen=True)
class Conditions:
    """The conditions of a run.

    Attributes:
        starts: Rows x (m), y (m) and theta (rad) of the robots at the first call, shape (3, N).
        adjacency: Weights of the graph then, shape (N, N): row i receives from column j.
        period: Time between two calls of the laws, in s.
        duration: Length of the run, in s.
        delay: Delay of messages, in s.
        threshold: Distance from the last position sent at which a robot sends its state, in m; 0
            if it sends every state, or has a condition of its own.
    """

    starts: Floats
    adjacency: Floats
    period: float
    duration: float = 0.0
    delay: float = 0.0
    threshold: float = 0.0

    @property
    def laplacian(self) -> Floats:
        """L = diag(sum_j a_ij) - A, shape (N, N)."""
        return graph.laplacian(self.adjacency)


def of_all_links(values: Floats, adjacency: Floats) -> float:
    """Return the value (N, N) that all links of a graph have; 0 if they differ."""
    found = values[adjacency > 0]
    return float(found[0]) if found.size and (found == found[0]).all() else 0.0
