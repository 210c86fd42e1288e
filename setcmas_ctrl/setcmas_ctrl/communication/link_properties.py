"""Properties of the links between robots: delay, loss and noise, and their random numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from setcmas_simu.arrays import Floats

Words = NDArray[np.uint64]

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.ones(1, dtype=np.uint64)
_BITS = 53  # of a float's significand


def streams_of(*parts: ArrayLike) -> Words:
    """Return a stream of random words for each combination of whole numbers, such as a link.

    Args:
        parts: Arrays of whole numbers that broadcast to a shape (n,).
    """
    words = np.zeros(1, dtype=np.uint64)
    for part in parts:
        words = word(words ^ np.asarray(part).astype(np.uint64), _FIRST)
    return words


def word(stream: Words, index: NDArray[Any]) -> Words:
    """Return random words at given indices of streams, uniform in 0 .. 2^64 - 1.

    SplitMix64, whose output is a hash of a counter (Steele, Lea and Flood, Fast splittable
    pseudorandom number generators, OOPSLA 2014; the finaliser is Stafford's variant 13).

    Args:
        stream: Streams from `streams_of`, shape (n,).
        index: Whole numbers from 0, of a shape that broadcasts to (n,) or (k, n).
    """
    words: Words = index.astype(np.uint64) * _GAMMA + stream
    words ^= words >> 30
    words *= 0xBF58476D1CE4E5B9
    words ^= words >> 27
    words *= 0x94D049BB133111EB
    words ^= words >> 31
    return words


def thresholds(probability: Floats) -> Words:
    """Return thresholds for `happens` from probabilities, the same shape."""
    return np.ceil(probability * 2.0**_BITS).astype(np.uint64)


def happens(words: Words, threshold: Words) -> NDArray[np.bool_]:
    """Return whether each event happens: its uniform number in [0, 1) is below its probability."""
    result: NDArray[np.bool_] = words >> (64 - _BITS) < threshold
    return result


def normal(words: Words) -> Floats:
    """Return two independent standard normal numbers per pair of words, shape (2, n).

    Box-Muller transform (Annals of Mathematical Statistics 29(2), 1958). The words are the same on
    every machine; the numbers are as far as its logarithm, sine and cosine are.
    """
    u, v = (words >> (64 - _BITS)) * 2.0**-_BITS
    result: Floats = np.empty(words.shape)
    angle = 2.0 * np.pi * v
    np.cos(angle, out=result[0])
    np.sin(angle, out=result[1])
    result *= np.sqrt(-2.0 * np.log(1.0 - u))  # u is below 1
    return result


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
