"""First-order lag behind a command that is held from one change to the next."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats


class HeldCommand:
    """One command over time, and what a first-order lag with dead time makes of it."""

    def __init__(self, t: Floats, u: Floats) -> None:
        """Take the times (s), sorted, and the commands, shape (K,); zero before the first."""
        changed = np.concatenate([[True], np.diff(u) != 0.0])
        self._t = np.concatenate([[t[0] - 1.0], t[changed]])
        self._u = np.concatenate([[0.0], u[changed]])
        held = np.diff(self._t) * self._u[:-1]
        self._sum = np.concatenate([[0.0], np.cumsum(held)])

    @property
    def changes(self) -> tuple[Floats, Floats]:
        """When the command changes, in s, and to what."""
        return self._t, self._u

    def lagging(self, lag: float) -> Floats:
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
            begin: When they begin, in s, shape (M,).
            end: When they end, in s, shape (M,).
            lag: Time constant in s.
            delay: Dead time in s.
        """
        return self.means_of(self.lagging(lag), begin, end, lag, delay)

    def means_of(
        self, speeds: Floats, begin: Floats, end: Floats, lag: float, delay: float
    ) -> Floats:
        """Return the same where the speeds at the changes are known."""
        ways = [self._way(speeds, lag, times - delay) for times in (begin, end)]
        means: Floats = (ways[1] - ways[0]) / (end - begin)
        return means

    def _way(self, speeds: Floats, lag: float, times: Floats) -> Floats:
        k = np.maximum(np.searchsorted(self._t, times, side='right') - 1, 0)
        since, u = np.maximum(times - self._t[k], 0.0), self._u[k]
        w = u + (speeds[k] - u) * np.exp(-since / max(lag, 1e-9))
        way: Floats = self._sum[k] + u * since - lag * w
        return way
