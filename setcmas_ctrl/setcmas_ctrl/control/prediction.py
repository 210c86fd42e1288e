"""What theory predicts of a run: `predict(conditions)` in a control script."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl import network
from setcmas_simu.arrays import Floats

_NOTHING = 1e-9

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
    """A law z' = -M (z - offsets), with the positions z = x + i y of all robots.

    A real M acts on both coordinates alike; a complex one also turns.

    Attributes:
        matrix: M in 1/s, shape (N, N), real or complex.
        formula: M in the terms of the law, such as 'K L'.
        offsets: Places of a formation, rows x and y in m, shape (2, N); 0 by default.
    """

    matrix: NDArray[Any]
    formula: str
    offsets: Floats | float = 0.0

    def positions(self, conditions: Conditions) -> tuple[Floats, Floats]:
        """Return the times of the calls and the end, and the positions then.

        Velocities are constant between two calls, so z(k + 1) = z(k) - h M (z(k) - offsets).

        Returns:
            Times in s, shape (K,), and positions in m, shape (K, 2, N).
        """
        end = conditions.duration
        calls = np.arange(0.0, end - _NOTHING, conditions.period)
        times: Floats = np.append(calls, end)
        x, y = conditions.starts[:2] - self.offsets
        found = np.empty((len(times), len(x)), complex)
        found[0] = x + 1j * y
        for k, period in enumerate(np.diff(times)):
            found[k + 1] = found[k] - period * (self.matrix @ found[k])
        return times, np.stack([found.real, found.imag], axis=1) + self.offsets

    @property
    def slowest_rate(self) -> float:
        """Rate of the slowest mode in 1/s: the least real part of an eigenvalue other than 0."""
        rates = np.sort(np.linalg.eigvals(self.matrix).real)
        return float(rates[1]) if len(rates) > 1 else 0.0

    def doubts(self, period: float, meet: bool = True) -> list[str]:
        """Return why robots do not get where they should; [] if they do.

        Args:
            period: Time between two calls in s.
            meet: Whether they should meet in this graph.
        """
        values = np.linalg.eigvals(self.matrix)
        doubts = []
        if meet and not network.reachable(np.abs(self.matrix) > _NOTHING).all(axis=0).any():
            doubts.append(
                'the graph at the start has no directed spanning tree; unless it changes, the '
                'robots do not all meet'
            )
        moving = values[np.abs(values) > _NOTHING]
        # With a rate of exactly 0 robots drive along circles, which sampling widens.
        if np.all(moving.real > _NOTHING) and np.abs(1.0 - period * moving).max(initial=0.0) > 1.0:
            most = 2.0 * np.min(moving.real / np.abs(moving) ** 2)
            doubts.append(
                f'the gain is too large for a sampling period of {period:g} s, so oscillations '
                f'grow; divide it by more than {period / most:.3g}'
            )
        return doubts


Prediction = LinearLaw | Mapping[str, Predicted]
"""A linear law, from which all metrics of consensus follow, or figures by names of metrics,
such as 'consensus.convergence_rate_1_s'."""

Predict = Callable[[Conditions], Prediction]
