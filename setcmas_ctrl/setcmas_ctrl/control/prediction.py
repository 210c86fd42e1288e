"""What theory predicts of a run: `predict(conditions)` in a control script."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from setcmas_simu.arrays import Floats

PREDICT = 'predict'
"""Name of the function in a control script."""


@dataclass(frozen=True)
class Conditions:
    """The conditions of a run that theory needs.

    Attributes:
        starts: Rows x (m), y (m) and theta (rad) of the robots when the laws are first called,
            shape (3, N).
        adjacency: Weights of the graph at the start, shape (N, N): row i receives from column j.
        period: Time between two calls of the laws, in s.
        duration: Length of the run, in s.
        delay: Delay of messages, in s.
        noise: Standard deviation of the noise on received positions, in m.
    """

    starts: Floats
    adjacency: Floats
    period: float
    duration: float
    delay: float = 0.0
    noise: float = 0.0

    @property
    def laplacian(self) -> Floats:
        """L = diag(sum_j a_ij) - A, shape (N, N)."""
        laplacian: Floats = np.diag(self.adjacency.sum(axis=1)) - self.adjacency
        return laplacian


class Predicted(NamedTuple):
    """A predicted figure.

    Attributes:
        value: Its value, in the unit of the metric.
        formula: Where it comes from, such as 'K lambda_2'.
    """

    value: float
    formula: str


@dataclass(frozen=True)
class LinearLaw:
    """A law p' = -M (p - offsets), for each coordinate.

    Attributes:
        matrix: M in 1/s, shape (N, N).
        formula: M in the terms of the law, such as 'K L'.
        offsets: Places of a formation, rows x and y in m, shape (2, N); 0 by default.
    """

    matrix: Floats
    formula: str
    offsets: Floats | float = 0.0

    def positions(self, conditions: Conditions) -> tuple[Floats, Floats]:
        """Return the times of the calls, shape (K,), and the positions then, shape (K, 2, N).

        Velocities are constant between two calls, so p(k + 1) = p(k) - h M (p(k) - offsets).
        """
        step = np.eye(len(self.matrix)) - conditions.period * self.matrix
        offset: Floats = conditions.starts[:2] - self.offsets
        count = round(conditions.duration / conditions.period)
        found: Floats = np.empty((count + 1, *offset.shape))
        for k in range(count + 1):
            found[k] = self.offsets + offset
            offset = offset @ step.T
        times: Floats = np.arange(count + 1, dtype=float) * conditions.period
        return times, found

    @property
    def slowest_rate(self) -> float:
        """Rate of the slowest mode in 1/s: the least real part of an eigenvalue other than 0."""
        rates = np.sort(np.linalg.eigvals(self.matrix).real)
        return float(rates[1]) if len(rates) > 1 else 0.0


Prediction = LinearLaw | Mapping[str, Predicted]
"""A linear law, from which all metrics of consensus follow, or figures by names of metrics,
such as 'consensus.convergence_rate_1_s'."""

Predict = Callable[[Conditions], Prediction]
