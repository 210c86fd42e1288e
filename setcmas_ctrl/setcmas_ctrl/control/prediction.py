"""What theory says of a run: functions `predict` and `doubts` of a control script."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl import network
from setcmas_simu.arrays import Floats

_NOTHING = 1e-6  # rounding leaves 1e-8 of a double eigenvalue 0

PREDICT = 'predict'
"""Name of the function in a control script that predicts figures of a run.

It returns a linear law, from which all metrics of consensus follow, or values `Predicted` by names
of metrics, such as 'consensus.convergence_rate_1_s'.
"""

DOUBTS = 'doubts'
"""Name of the function that returns texts: why the law may not do what it should."""


@dataclass(frozen=True)
class Conditions:
    """The conditions of a run that `doubts` gets.

    Attributes:
        starts: Rows x (m), y (m) and theta (rad) of the robots when the laws are first called,
            shape (3, N); while it runs, NaN for robots that robot 1 does not know.
        adjacency: Weights of the graph at the start, shape (N, N): row i receives from column j.
        period: Time between two calls of the laws, in s.
        duration: Length of the run, in s; inf while it runs.
    """

    starts: Floats
    adjacency: Floats
    period: float
    duration: float

    @property
    def laplacian(self) -> Floats:
        """L = diag(sum_j a_ij) - A, shape (N, N)."""
        return np.diag(self.adjacency.sum(axis=1)) - self.adjacency


@dataclass(frozen=True)
class RunConditions(Conditions):
    """The conditions of a finished run, which `predict` gets.

    Attributes:
        delay: Delay of messages, in s.
        noise: Standard deviation of the noise on received positions, in m.
        threshold: Distance from the last position sent at which a robot sends its state, in m;
            0 if it sends every state.
        holds_own: Whether a robot uses its own position as last sent, too.
        range: Distance beyond which robots have no link, in m.
    """

    delay: float = 0.0
    noise: float = 0.0
    threshold: float = 0.0
    holds_own: bool = False
    range: float = inf


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

    A real M acts on both coordinates alike; a complex one also turns. Rows and columns beyond N
    are memories of robots 1, 2, ..., which start at 0. Robots receive what they use of others, so
    it is late and noisy.

    Attributes:
        matrix: M in 1/s, shape (N, N), or larger with memories, real or complex.
        formula: M in the terms of the law, such as 'K L'.
        offsets: Places of a formation, rows x and y in m, a column per row of M; 0 by default.
        own_delay: Age of the own position that a robot uses, in s.
        mixes_axes: Whether M, of shape (2 N, 2 N), acts on x of all robots, followed by y.
    """

    matrix: NDArray[Any]
    formula: str
    offsets: Floats | float = 0.0
    own_delay: float = 0.0
    mixes_axes: bool = False

    def _received(self, count: int) -> NDArray[Any]:
        """Return the part of M through which each of `count` robots uses what it receives."""
        robot = np.arange(len(self.matrix)) % count
        return np.where(robot[:, None] != robot, self.matrix, 0.0)

    def positions(self, conditions: RunConditions) -> tuple[Floats, Floats]:
        """Return the times of the calls and the end, and the positions then.

        Velocities are constant between two calls, so z(k + 1) = z(k) - h M (z(k) - offsets), with
        older positions where they are late.

        Returns:
            Times in s, shape (K,), and positions in m, shape (K, 2, N).
        """
        end, count = conditions.duration, conditions.starts.shape[1]
        calls = np.arange(0.0, end - _NOTHING, conditions.period)
        times: Floats = np.append(calls, end)
        starts = np.zeros((2, count if self.mixes_axes else len(self.matrix)))
        starts[:, :count] = conditions.starts[:2]
        x, y = starts - self.offsets
        found = np.empty((len(times), len(self.matrix)), complex)
        found[0] = np.append(x, y) if self.mixes_axes else x + 1j * y

        def late(k: int, delay: float) -> NDArray[Any]:
            at = max(k - delay / conditions.period, 0.0)
            last = int(at)
            return np.asarray(found[last] + at % 1.0 * (found[min(last + 1, k)] - found[last]))

        received = self._received(count)
        own = self.matrix - received
        for k, period in enumerate(np.diff(times)):
            rise = own @ late(k, self.own_delay) + received @ late(k, conditions.delay)
            found[k + 1] = found[k] - period * rise
        if self.mixes_axes:
            return times, found.real.reshape(-1, 2, count) + self.offsets
        positions = np.stack([found.real, found.imag], axis=1) + self.offsets
        return times, positions[..., :count]

    @property
    def slowest_rate(self) -> float:
        """Rate of the slowest mode in 1/s: the least real part of an eigenvalue other than 0."""
        rates = self._moving().real
        return float(rates.min()) if len(rates) else 0.0

    def _moving(self) -> NDArray[np.complex128]:
        values: NDArray[np.complex128] = np.linalg.eigvals(self.matrix)
        return values[np.abs(values) > _NOTHING]

    def _contraction(self, conditions: Conditions) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return B and G of delta(k + 1) = B delta(k) - G e(k).

        delta are the positions relative to their mean, e the errors of received positions.
        """
        count = len(self.matrix)
        centred = np.eye(count) - 1.0 / count
        received = self._received(count)
        return (
            centred @ (np.eye(count) - conditions.period * self.matrix),
            conditions.period * received,
        )

    def spread_by_noise(self, conditions: RunConditions) -> float:
        """Return the RMS distance to the centre that noise causes in the long run, in m.

        Errors e are independent for each link, so their covariance P = B P B' + S. The result is
        inf where P grows without bound.
        """
        B, gains = self._contraction(conditions)
        if np.abs(np.linalg.eigvals(B)).max() > 1.0 - _NOTHING:
            return np.inf
        count = len(B)
        centred = np.eye(count) - 1.0 / count
        variances = np.sum(np.abs(conditions.noise * gains) ** 2, axis=1)
        P = centred @ np.diag(variances) @ centred
        while np.abs(B).max() > _NOTHING:  # each doubles the number of calls
            P, B = P + B @ P @ B.conj().T, B @ B
        return float(np.sqrt(2.0 * np.trace(P).real / count))

    def spread_by_events(self, conditions: RunConditions) -> float:
        """Return an upper bound of the RMS distance to the centre at the end, in m.

        Errors e are at most the threshold of each robot: |delta(k + 1)| <= |B| |delta| + |G e|.
        Where own positions are those sent, G is all of h M, as in Seyboth, Dimarogonas and
        Johansson, Automatica 49(1), 2013. The result is inf where |B| >= 1.
        """
        B, gains = self._contraction(conditions)
        if conditions.holds_own:
            gains = conditions.period * self.matrix
        shrinks = np.linalg.norm(B, 2)
        if shrinks > 1.0 - _NOTHING:
            return np.inf
        count, x_y = len(B), conditions.starts[:2]
        at_start = np.linalg.norm(x_y - x_y.mean(axis=1)[:, None]) / np.sqrt(count)
        centred = gains - gains.mean(axis=0)
        bound = np.linalg.norm(centred, 2) * conditions.threshold / (1.0 - shrinks)
        return float(bound + shrinks ** (conditions.duration / conditions.period) * at_start)

    def doubts(self, period: float, meet: bool = True) -> list[str]:
        """Return why robots do not get where they should; [] if they do.

        Args:
            period: Time between two calls in s.
            meet: Whether they should meet in this graph.
        """
        doubts = []
        if meet and not network.reachable(np.abs(self.matrix) > _NOTHING).all(axis=0).any():
            doubts.append(
                'the graph at the start has no directed spanning tree; unless it changes, the '
                'robots do not all agree'
            )
        moving = self._moving()
        # With a rate of exactly 0 robots drive along circles, which sampling widens.
        if not len(moving) or np.any(moving.real < _NOTHING):
            return doubts
        most, late = 2.0 * np.min(moving.real / np.abs(moving) ** 2), ''
        if self.own_delay:  # of all positions, as z(k + 1) = z(k) - h M z(k - own_delay / h)
            most *= np.sin(np.pi / (4.0 * self.own_delay / period + 2.0))
            late = f' and positions that are {self.own_delay:g} s old'
        if period > most:
            doubts.append(
                f'the gain is too large for a sampling period of {period:g} s{late}, so '
                f'oscillations grow; divide it by more than {period / most:.3g}'
            )
        return doubts


Doubts = Callable[[Conditions], Iterable[str] | str | None]


def texts_of(doubts: Doubts, conditions: Conditions) -> list[str]:
    """Return the texts of a law's function `doubts`."""
    found = doubts(conditions) or ()
    return [found] if isinstance(found, str) else [*found]
