"""Least squares fit of gain, lag and delay to commands and measured speeds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import needs
from setcmas_simu.robots.identified_robot import LONGEST_DELAY_S, Response


class HeldCommand:
    """A command over time, and the answer of a first-order lag with dead time."""

    def __init__(self, t: Floats, u: Floats) -> None:
        """Take the times (s), sorted, and the commands, shape (K,); zero before the first."""
        changed = np.concatenate([[True], np.diff(u) != 0.0])
        self._t = np.concatenate([[t[0] - 1.0], t[changed]])
        self._u = np.concatenate([[0.0], u[changed]])
        held = np.diff(self._t) * self._u[:-1]
        self._sum = np.concatenate([[0.0], np.cumsum(held)])
        self._lag, self._speeds = 0.0, self._lagging(0.0)  # of the last call

    @property
    def changes(self) -> tuple[Floats, Floats]:
        """Times of changes in s, and the commands from then on."""
        return self._t, self._u

    def _lagging(self, lag: float) -> Floats:
        """Return the speeds w at the changes, lag w' = u - w, shape (K + 1,); lag in s."""
        shares = np.exp(-np.diff(self._t) / max(lag, 1e-9)).tolist()
        speeds = [0.0]
        for share, u in zip(shares, self._u.tolist(), strict=False):
            speeds.append(u + (speeds[-1] - u) * share)
        return np.array(speeds)

    def means(self, begin: Floats, end: Floats, lag: float, delay: float) -> Floats:
        """Return the mean speeds over windows, of gain 1.

        The integral of w is that of u less lag times the change of w.

        Args:
            begin: Their starts in s, shape (M,).
            end: Their ends in s, shape (M,).
            lag: Time constant in s.
            delay: Dead time in s.
        """
        if lag != self._lag:
            self._lag, self._speeds = lag, self._lagging(lag)
        ways = [self._way(times - delay) for times in (begin, end)]
        return (ways[1] - ways[0]) / (end - begin)

    def _way(self, times: Floats) -> Floats:
        k = np.maximum(np.searchsorted(self._t, times, side='right') - 1, 0)
        since, u = np.maximum(times - self._t[k], 0.0), self._u[k]
        w = u + (self._speeds[k] - u) * np.exp(-since / max(self._lag, 1e-9))
        way: Floats = self._sum[k] + u * since - self._lag * w
        return way


LEAST_FIT = 30.0
"""Percent of the motion that a usable model explains."""

MOST_DOUBT_S = 0.1
"""Largest standard error of a known lag and delay, in s."""

_MOST_GAIN_DOUBT = 0.1
_LAGS_S = np.concatenate([[0.0], np.geomspace(0.02, 1.0, 12)])
_DELAYS_S = np.linspace(0.0, 1.0, 41)
_MOST_EARLY_S = 0.15
"""Longest lead of a simulated motion to its command: a step at 10 Hz, and jitter."""

_AT_ONCE_S = 0.02
_LEAST = np.array([-np.inf, 0.0, 0.0])  # gain, lag, delay
_MOST = np.array([np.inf, LONGEST_DELAY_S, LONGEST_DELAY_S])
_PROBE_S = 2e-3
_SINGULAR = 1e5
_LEAST_SIGMA = 1e-12


@dataclass(frozen=True)
class Fit:
    """Fitted response of a speed to its command.

    Attributes:
        response: Gain, lag and delay.
        quality: Share of the measured motion that the model explains, in percent.
    """

    response: Response
    errors: Response
    quality: float

    @property
    def gain_known(self) -> bool:
        """Whether the run determines the gain."""
        doubt = self.errors.gain / max(abs(self.response.gain), 1e-9)
        return self.quality >= LEAST_FIT and doubt <= _MOST_GAIN_DOUBT

    @property
    def times_known(self) -> bool:
        """Whether the run determines lag and delay, too."""
        return self.gain_known and max(self.errors.lag, self.errors.delay) <= MOST_DOUBT_S


@dataclass(frozen=True)
class Measured:
    """Mean speeds in windows, and the command behind them.

    Attributes:
        begin: Starts of the windows in s, shape (K,).
        end: Their ends in s, shape (K,).
        y: The mean speeds, shape (K,).
        overlap: Number of windows that overlap.
    """

    command: HeldCommand
    begin: Floats
    end: Floats
    y: Floats
    overlap: float

    def predicted(self, response: Response) -> Floats:
        """Return the mean speeds of a model, shape (K,)."""
        means = self.command.means(self.begin, self.end, response.lag, response.delay)
        return response.gain * means


def fitted(measured: Measured, lag: float | None = None) -> Fit:
    """Return the gain, lag and delay with the least squares of errors.

    Speeds are simulated from the commands alone, an output-error model (Ljung, System
    Identification, 2nd edition, 1999, section 4.2). The best point of a grid of lags and delays,
    each with the gain of linear least squares, is the start of `scipy.optimize.least_squares`.
    Standard errors are those of section 9.4, for as many windows as do not overlap; the quality
    is 1 - |y - model| / |y - mean| (section 16.4 has its square).

    A simulation applies a command to the whole step in which it arrives, so poses may lead the
    command. Without any lag or delay, the gain is that of the best lead; the delay is 0 then.

    Args:
        measured: At least a window.
        lag: The lag in s if it is known.

    Raises:
        SetcmasError: scipy is missing.
    """
    lags = _LAGS_S if lag is None else np.array([lag])
    free = np.array([True, lag is None, True])
    best = _nearest(measured, _best(measured, lags, _DELAYS_S), free)
    if best.lag + best.delay < _AT_ONCE_S:
        early = _best(measured, np.zeros(1), np.linspace(-_MOST_EARLY_S, 0.0, 151))
        best = early if early.delay < 0.0 else best
    y, e = measured.y, measured.y - measured.predicted(best)
    apart = float(np.linalg.norm(y - y.mean()))
    quality = 100.0 * (1.0 - float(np.linalg.norm(e)) / apart) if apart > 0.0 else 0.0
    errors = _errors(measured, best, free)
    return Fit(replace(best, delay=max(0.0, best.delay)), errors, quality)


def _best(measured: Measured, lags: Floats, delays: Floats) -> Response:
    best, least = Response(gain=0.0), np.inf
    for lag in lags.tolist():
        for delay in delays.tolist():
            means = measured.predicted(Response(1.0, lag, delay))
            power = float(means @ means)
            gain = float(means @ measured.y) / power if power > 0.0 else 0.0
            error = float(np.sum(np.square(measured.y - gain * means)))
            if error < least:
                best, least = Response(gain, lag, delay), error
    return best


def _nearest(measured: Measured, begin: Response, free: NDArray[np.bool_]) -> Response:
    """Return the response with the least squares near another, over its free values.

    Raises:
        SetcmasError: scipy is missing.
    """
    with needs('identify'):
        from scipy.optimize import least_squares
    start = np.array([begin.gain, begin.lag, begin.delay])

    def response(values: Floats) -> Response:
        all_values = start.copy()
        all_values[free] = values
        return Response(*all_values.tolist())

    found = least_squares(
        lambda values: measured.predicted(response(values)) - measured.y,
        start[free],
        jac=lambda values: _jacobian(measured, response(values))[:, free],
        bounds=(_LEAST[free], _MOST[free]),
    )
    return response(found.x)


def _jacobian(measured: Measured, at: Response) -> Floats:
    """Return how predictions change with gain, lag and delay, shape (K, 3)."""
    unit, here = measured.predicted(replace(at, gain=1.0)), measured.predicted(at)
    columns = [unit]
    for name in ('lag', 'delay'):
        nudged = replace(at, **{name: getattr(at, name) + _PROBE_S})
        columns.append((measured.predicted(nudged) - here) / _PROBE_S)
    return np.column_stack(columns)


def _errors(measured: Measured, best: Response, free: NDArray[np.bool_]) -> Response:
    """Return the standard errors of gain, lag and delay; infinite if undetermined.

    A run may determine only the sum of lag and delay; that sum then bounds both errors.
    """
    J = _jacobian(measured, best)
    e = measured.y - measured.predicted(best)
    square = float(e @ e) * measured.overlap / max(1.0, len(e) - 3 * measured.overlap)
    sigma = max(np.sqrt(square), _LEAST_SIGMA)  # 0 times a spread without end is no number
    gain, total = sigma * _spread(J[:, [0, 2]])
    if not free[1]:
        return Response(float(gain), 0.0, float(total))
    most = best.lag + abs(best.delay) + total
    errors = np.minimum(sigma * _spread(J), [np.inf, most, most])
    return Response(float(gain if np.isinf(errors[0]) else errors[0]), *errors[1:].tolist())


def _spread(J: Floats) -> Floats:
    """Return the standard errors for errors of 1 in the speeds, infinite if J is singular."""
    sizes = np.linalg.norm(J, axis=0)
    if not sizes.all() or np.linalg.cond(J / sizes) > _SINGULAR:
        return np.full(J.shape[1], np.inf)
    spread: Floats = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    return spread
