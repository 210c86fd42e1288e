"""Predictions: conditions of a run, and what theory says of a linear law under them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from math import log
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    excludes: frozenset[Departure] = frozenset({Departure.CHANGES, Departure.DELAY})


@dataclass(frozen=True)
class Conditions:
    """The conditions of a run.

    Attributes:
        starts: Rows x (m), y (m) and theta (rad) of the robots at the first call, shape (3, N).
        adjacency: Weights of the graph then, shape (N, N): row i receives from column j.
        period: Time between two calls of the laws, in s.
        duration: Length of the run, in s.
        threshold: Distance from the last position sent at which a robot sends its state, in m; 0
            if it sends every state, or has a condition of its own.
    """

    starts: Floats
    adjacency: Floats
    period: float
    duration: float = 0.0
    threshold: float = 0.0

    @property
    def laplacian(self) -> Floats:
        """L = diag(sum_j a_ij) - A, shape (N, N)."""
        return graph.laplacian(self.adjacency)


_NOTHING = 1e-7  # rounding leaves 1e-8 of a double eigenvalue 0
_MEETING_POINT = {
    'consensus': ('final_centre_x_m', 'final_centre_y_m'),
    'alignment': ('final_mean_vx_m_s', 'final_mean_vy_m_s'),
}
"""Metrics by the names of tasks."""


@dataclass(frozen=True)
class LinearLaw:
    """A law z' = -M z of the positions of all robots, or of values that they send each other.

    Called every h s it is the sampled model z(k + 1) = z(k) - h M z(k).

    Attributes:
        matrix: M in 1/s, shape (N, N), or a multiple with memories of robots 1, 2, ...; a complex
            M acts on x + i y, and also turns.
        formula: M in the terms of the law, such as 'K L'.
        task: Task whose metrics measure the agreement, 'consensus' or 'alignment'; '' if none do.
        kept: Number of modes that the law keeps: of consensus one, the meeting point.
        starts: Values at the start, if they are no positions: a row per coordinate of their mean,
            shape (2, N), or none, shape (0, N).
    """

    matrix: NDArray[Any]
    formula: str
    task: str = ''
    kept: int = 1
    starts: Floats | None = None

    def theorems(self, conditions: Conditions) -> Iterator[Theorem]:
        """Yield rates, the meeting point, and the bound of events."""
        h = conditions.period
        values = np.linalg.eigvals(self.matrix)
        of_robots = len(values) == len(conditions.adjacency)
        values = values[np.argsort(np.abs(values))][self.kept :]
        # The factor by which the slowest mode changes from call to call.
        factor = complex(max(1.0 - h * values, key=abs, default=0.0))
        if not _NOTHING < abs(factor) < 1.0 - _NOTHING:
            return
        swings = abs(factor.imag) > _NOTHING and not of_robots  # errors rise and fall
        metric = f'{"modes" if swings else self.task or "modes"}.convergence_rate_1_s'
        is_symmetric = np.allclose(self.matrix, self.matrix.T)
        if self.kept == 1 and h * np.abs(values).max() < 1.0:
            name = 'lambda_2' if is_symmetric else 'least Re lambda'
            yield Theorem(metric, float(values.real.min()), f'{name} of {self.formula}')
        rho = f'sampled model, h = {h:g} s: -ln(rho)/h'
        yield Theorem(metric, -log(abs(factor)) / h, rho)
        if self.kept == 1 and self.task and of_robots:
            yield from self._meeting_point(conditions)
        is_of_positions = of_robots and self.starts is None
        if conditions.threshold and is_of_positions and is_symmetric:
            yield self._event_bound(conditions)

    def _meeting_point(self, conditions: Conditions) -> Iterator[Theorem]:
        """Yield the place, or the value, on which robots agree: if w' M = 0, w' z is constant."""
        values, vectors = np.linalg.eig(self.matrix.T)
        w = vectors[:, np.abs(values).argmin()].real
        starts = conditions.starts if self.starts is None else self.starts
        for name, places in zip(_MEETING_POINT[self.task], starts, strict=False):
            by = "mean of the starts with weights w, w' M = 0"
            yield Theorem(f'{self.task}.{name}', float(w @ places / w.sum()), by)

    def _event_bound(self, conditions: Conditions) -> Theorem:
        """Return the bound of the RMS distance to the centre at the end, in an undirected graph.

        It tends to |L| c / lambda_2 (Seyboth, Dimarogonas and Johansson, Automatica 49(1), 2013,
        theorem 3.1). This one holds for the sampled model, and adds what is left of the distance
        at the start.
        """
        h, starts = conditions.period, conditions.starts[:2]
        values = np.linalg.eigvalsh(self.matrix)
        shrinks = float(np.abs(1.0 - h * values[1:]).max())
        left = np.linalg.norm(starts - starts.mean(axis=1)[:, None]) / np.sqrt(len(values))
        bound = h * values[-1] * conditions.threshold / (1.0 - shrinks)
        bound += shrinks ** (conditions.duration / h) * left
        return Theorem(
            'consensus.disagreement_at_end_m',
            float(bound),
            f'the upper bound |L| c / lambda_2, c = {conditions.threshold:g} m',
            frozenset(Departure) - {Departure.EVENTS},
        )


@dataclass(frozen=True)
class Prediction:
    """What theory says of a run.

    Attributes:
        linear: The law of all robots together, if it is linear.
        theorems: Further figures.
    """

    linear: LinearLaw | None = None
    theorems: tuple[Theorem, ...] = ()
