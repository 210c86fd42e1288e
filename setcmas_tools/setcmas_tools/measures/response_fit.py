"""Least squares fit of gain, lag and delay to commands and measured speeds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import needs
from setcmas_simu.robots.identified_robot import LONGEST_DELAY_S, Response

LEAST_FIT = 30.0
"""Percent of the motion that a usable model explains."""

MOST_DOUBT_S = 0.1
"""Largest standard error of a known lag and delay, in s."""

_MOST_GAIN_DOUBT = 0.1
_LAGS_S = np.concatenate([[0.0], np.geomspace(0.02, 1.0, 12)])
_MOST_EARLY_S = 0.15
"""Longest lead of a simulated motion to its command: a step at 10 Hz, and jitter."""

_DELAYS_S = np.arange(-_MOST_EARLY_S, 1.0, 0.025)
_SINGULAR = 1e5


@dataclass(frozen=True)
class Fit:
    """Fitted response of a speed to its command.

    Attributes:
        response: Gain, lag and delay.
        errors: Their standard errors.
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


@dataclass
class MeasuredSpeeds:
    """Mean speeds of a robot in M windows, and the K commands behind them.

    Attributes:
        t: Times of the commands in s, sorted, shape (K,); each is held until the next one.
        u: The commands, shape (K,); zero before the first.
        begin: Starts of the windows in s, shape (M,).
        end: Their ends in s, shape (M,).
        y: The mean speeds, shape (M,).
        overlap: Number of windows that overlap.
    """

    t: Floats
    u: Floats
    begin: Floats
    end: Floats
    y: Floats
    overlap: float

    def __post_init__(self) -> None:
        changed = np.concatenate([[True], np.diff(self.u) != 0.0])
        self._t = np.concatenate([[self.t[0] - 1.0], self.t[changed]])
        self._u = np.concatenate([[0.0], self.u[changed]])
        held = np.diff(self._t) * self._u[:-1]
        self._sum = np.concatenate([[0.0], np.cumsum(held)])
        self._lag, self._speeds = 0.0, self._lagging(0.0)  # of the last call

    def _lagging(self, lag: float) -> Floats:
        """Return the speeds w at the changes, lag w' = u - w; lag in s."""
        shares = np.exp(-np.diff(self._t) / max(lag, 1e-9)).tolist()
        speeds = [0.0]
        for share, u in zip(shares, self._u.tolist(), strict=False):
            speeds.append(u + (speeds[-1] - u) * share)
        return np.array(speeds)

    def predicted(self, response: Response) -> Floats:
        """Return the mean speeds of a first-order lag with dead time, shape (M,).

        The integral of w is that of u less lag times the change of w.
        """
        if response.lag != self._lag:
            self._lag, self._speeds = response.lag, self._lagging(response.lag)
        ways = [self._way(times - response.delay) for times in (self.begin, self.end)]
        means = (ways[1] - ways[0]) / (self.end - self.begin)
        return response.gain * means

    def _way(self, times: Floats) -> Floats:
        k = np.maximum(np.searchsorted(self._t, times, side='right') - 1, 0)
        since, u = np.maximum(times - self._t[k], 0.0), self._u[k]
        w = u + (self._speeds[k] - u) * np.exp(-since / max(self._lag, 1e-9))
        way: Floats = self._sum[k] + u * since - self._lag * w
        return way


def fitted(measured: MeasuredSpeeds) -> Fit:
    """Return the gain, lag and delay with the least squares of errors.

    Speeds are simulated from the commands alone, an output-error model (Ljung, System
    Identification, 2nd edition, 1999, section 4.2). The best point of a grid of lags and delays,
    each with the gain of linear least squares, is the start of `scipy.optimize.least_squares`.
    Standard errors are at least those of section 9.4, for as many windows as do not overlap; the
    quality is 1 - |y - model| / |y - mean| (section 16.4 has its square).

    A simulation applies a command to the whole step in which it arrives, so poses may lead the
    command. The delay is 0 then, and no better known than that lead.

    Args:
        measured: At least a window.

    Raises:
        SetcmasError: scipy is missing.
    """
    best, errors = _nearest(measured, _best_on_grid(measured))
    e = measured.y - measured.predicted(best)
    apart = float(np.linalg.norm(measured.y - measured.y.mean()))
    quality = 100.0 * (1.0 - float(np.linalg.norm(e)) / apart) if apart > 0.0 else 0.0
    lead = max(0.0, -best.delay)
    errors = replace(errors, delay=errors.delay + lead)
    return Fit(replace(best, delay=best.delay + lead), errors, quality)


def _best_on_grid(measured: MeasuredSpeeds) -> Response:
    best, least = Response(gain=0.0), np.inf
    for lag in _LAGS_S.tolist():
        for delay in _DELAYS_S.tolist():
            means = measured.predicted(Response(1.0, lag, delay))
            power = float(means @ means)
            gain = float(means @ measured.y) / power if power > 0.0 else 0.0
            error = float(np.sum(np.square(measured.y - gain * means)))
            if error < least:
                best, least = Response(gain, lag, delay), error
    return best


def _nearest(measured: MeasuredSpeeds, start: Response) -> tuple[Response, Response]:
    """Return the response with the least squares near another, and the standard errors.

    The errors of values that the run does not determine are infinite.

    Raises:
        SetcmasError: scipy is missing.
    """
    with needs('identify'):
        from scipy.optimize import least_squares

    found = least_squares(
        lambda values: measured.predicted(Response(*values)) - measured.y,
        [start.gain, start.lag, start.delay],
        bounds=([-np.inf, 0.0, -_MOST_EARLY_S], [np.inf, LONGEST_DELAY_S, LONGEST_DELAY_S]),
    )
    errors = _standard_errors(found.jac, found.fun, measured)
    return Response(*found.x.tolist()), Response(*errors.tolist())


def _standard_errors(J: Floats, e: Floats, measured: MeasuredSpeeds) -> Floats:
    """Return the standard errors for the residuals e, infinite if the Jacobian J is singular.

    What the model leaves out is not noise: it is large in some manoeuvres and small in others. So
    the variances are at least those of residuals that depend on each other within each second
    (White, Econometrica 48, 1980, with sums over clusters).
    """
    sizes = np.linalg.norm(J, axis=0)
    if not sizes.all() or np.linalg.cond(J / sizes) > _SINGULAR:
        return np.full(J.shape[1], np.inf)
    inverse = np.linalg.inv(J.T @ J)
    apart = max(1.0, len(e) - J.shape[1] * measured.overlap)
    noise = float(e @ e) * measured.overlap / apart * np.diag(inverse)
    seconds = np.unique(np.floor(measured.begin), return_index=True)[1]
    scores = np.add.reduceat(J * e[:, np.newaxis], seconds) @ inverse
    errors: Floats = np.sqrt(np.maximum(noise, np.sum(np.square(scores), axis=0)))
    return errors
