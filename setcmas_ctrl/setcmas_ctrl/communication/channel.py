"""Channels between robots: delay, loss and noise of each link."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats


@dataclass(frozen=True)
class LinkChannel:
    """How one link differs from the others; None where it does not.

    Attributes:
        receiver: Number of the robot that hears.
        sender: Number of the robot that is heard.
        delay: In s.
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
    """The links of a fleet, [i][j] of each matrix for robot i + 1 that hears robot j + 1.

    Attributes:
        delay: In s, shape (N, N).
        loss: Probabilities from 0 to 1, shape (N, N).
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
        """Return links that are all alike, but for those that are named."""
        shape = (nb_robots, nb_robots)
        channel = cls(np.full(shape, delay), np.full(shape, loss), np.full(shape, noise))
        for link in links:
            for name in ('delay', 'loss', 'noise'):
                if (value := getattr(link, name)) is not None:
                    getattr(channel, name)[link.receiver - 1, link.sender - 1] = value
        return channel

    @property
    def is_random(self) -> bool:
        """Whether messages may be lost or changed."""
        return bool(self.loss.any() or self.noise.any())

    @property
    def is_perfect(self) -> bool:
        """Whether every message arrives at once and as it was."""
        return not (self.is_random or self.delay.any())
