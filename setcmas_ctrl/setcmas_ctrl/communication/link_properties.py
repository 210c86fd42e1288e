"""Properties of the links between robots: delay, loss and noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats


@dataclass(frozen=True)
class LinkChannel:
    """Properties of one link; None where it is like all others.

    Attributes:
        receiver: Number of the receiving robot.
        sender: Number of the sending robot.
        delay: Delay in s.
        loss: Probability that a message is lost.
        noise: Standard deviation of the noise on each coordinate of a received position, in m.
    """

    receiver: int
    sender: int
    delay: float | None = None
    loss: float | None = None
    noise: float | None = None


@dataclass(frozen=True)
class Channel:
    """Properties of all links; row i, column j is the link to robot i + 1 from robot j + 1.

    Attributes:
        delay: Delays in s, shape (N, N).
        loss: Probabilities of loss, shape (N, N).
        noise: Standard deviations in m, shape (N, N).
    """

    delay: Floats
    loss: Floats
    noise: Floats

    @classmethod
    def of(
        cls,
        nb_robots: int,
        delay: float = 0.0,
        loss: float = 0.0,
        noise: float = 0.0,
        links: Iterable[LinkChannel] = (),
    ) -> Channel:
        """Return equal links, except for those listed in `links`."""
        shape = (nb_robots, nb_robots)
        channel = cls(np.full(shape, delay), np.full(shape, loss), np.full(shape, noise))
        for link in links:
            for name in ('delay', 'loss', 'noise'):
                if (value := getattr(link, name)) is not None:
                    getattr(channel, name)[link.receiver - 1, link.sender - 1] = value
        return channel

    @property
    def is_perfect(self) -> bool:
        """Whether every message arrives at once and unchanged."""
        return not (self.loss.any() or self.noise.any() or self.delay.any())
