"""Counts of the messages on each link."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats


@dataclass
class LinkCounts:
    """What went over links; rows are receivers, columns are senders.

    Attributes:
        sent: Messages that were sent while the receiver heard the sender.
        received: Those that have arrived.
        lost: Those that never will.
        first: Time at which the first one arrived in s, NaN if none has.
        last: Time at which the last one arrived in s, NaN if none has.
    """

    sent: NDArray[np.int64]
    received: NDArray[np.int64]
    lost: NDArray[np.int64]
    first: Floats
    last: Floats

    @classmethod
    def zero(cls, nb_receivers: int, nb_senders: int) -> LinkCounts:
        """Return counts before the first message."""
        shape = (nb_receivers, nb_senders)
        sent, received, lost = np.zeros((3, *shape), dtype=np.int64)
        first, last = np.full((2, *shape), np.nan)
        return cls(sent, received, lost, first, last)

    @property
    def mean_interval(self) -> Floats:
        """Mean time between arrivals in s; NaN for fewer than two."""
        intervals = np.where(self.received > 1, self.received - 1, np.nan)
        result: Floats = (self.last - self.first) / intervals
        return result
