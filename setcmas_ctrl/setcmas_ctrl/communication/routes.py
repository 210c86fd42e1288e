"""Links as arrays: those that are up, and counts of their messages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.communication import draws
from setcmas_ctrl.communication.channel import Channel
from setcmas_ctrl.communication.draws import Words
from setcmas_simu.arrays import Floats


@dataclass
class LinkCounts:
    """Counts of messages on links; rows are receivers, columns are senders.

    Attributes:
        sent: Messages sent while the link was up.
        received: Messages that arrived.
        lost: Messages that were lost.
        first: Time of the first arrival in s; NaN if none.
        last: Time of the last arrival in s; NaN if none.
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


Indices = NDArray[np.intp]
Choice = slice | Indices | NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Routes:
    """Links from N senders to R receivers, sorted by sender.

    Attributes:
        senders: Columns of the senders, shape (n,).
        cells: Places of the links in a flattened matrix (R, N), shape (n,).
        held: Places of x, y, theta in a flattened array (R, 3, N), shape (3, n).
        delay: In s, shape (n,).
        loss: Thresholds of `draws.happens`, shape (n,).
        noise: Standard deviations in m, shape (n,).
        streams: Streams of random words, shape (n,).
    """

    senders: Indices
    cells: Indices
    held: Indices
    delay: Floats
    loss: Words
    noise: Floats
    streams: Words

    @classmethod
    def of(cls, up: NDArray[np.bool_], channel: Channel, streams: Words) -> Routes:
        """Return the links that a matrix names.

        Args:
            up: Which they are, shape (R, N).
            channel: What happens on each link, matrices (R, N).
            streams: The streams of each link, shape (R, N).
        """
        senders, rows = np.nonzero(up.T)
        nb_robots = up.shape[1]
        return cls(
            senders,
            rows * nb_robots + senders,
            (3 * rows + np.arange(3)[:, None]) * nb_robots + senders,
            channel.delay[rows, senders],
            draws.thresholds(channel.loss[rows, senders]),
            channel.noise[rows, senders],
            streams[rows, senders],
        )

    def __getitem__(self, which: Choice) -> Routes:
        """Return a selection of the links."""
        return Routes(
            self.senders[which],
            self.cells[which],
            self.held[:, which],
            self.delay[which],
            self.loss[which],
            self.noise[which],
            self.streams[which],
        )

    def sent_by(self, senders: Indices, nb_senders: int) -> Routes:
        """Return the links from some of the senders, which are sorted."""
        if len(senders) == nb_senders:
            return self
        if len(senders) == 1:
            begin, end = np.searchsorted(self.senders, [senders[0], senders[0] + 1]).tolist()
            return self[begin:end]
        sending = np.zeros(nb_senders, dtype=bool)
        sending[senders] = True
        return self[np.flatnonzero(sending[self.senders])]
