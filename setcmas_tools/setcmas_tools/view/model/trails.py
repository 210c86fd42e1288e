"""Trails behind the robots, in chunks: only the newest one changes, old ones are dropped whole."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float32]

LENGTH_S = 30.0
"""Default length of a trail, in s of driving."""
LONGEST_S = 120.0

_SAMPLE_S = 0.2
_SEGMENTS = 15  # per robot and chunk
_HEIGHT_M = 0.012  # above the ground, or they would flicker through it
_LONGEST_GAP_S = 1.0
_STILL_M = 1e-4


@dataclass
class Chunk:
    """A piece of the trails of all robots.

    Attributes:
        number: Different for each chunk.
        robots: Whose trails these are.
        begin: On the clock of `Trails`, in s.
        points: Segments in m, shape (N, S, 2, 3); those to come have length 0.
    """

    number: int
    robots: tuple[int, ...]
    begin: float
    points: Points


class Trails:
    """The trails of a fleet over the last seconds in which some robot moved.

    Attributes:
        length_s: How long they are.
        chunks: Oldest first; the last one grows.
    """

    def __init__(self, length_s: float = LENGTH_S) -> None:
        """Start without trails."""
        self.length_s = length_s
        self.chunks: deque[Chunk] = deque()
        self._clock = 0.0
        self._time: float | None = None
        self._filled = 0
        self._sampled = 0.0
        self._xy = np.empty((2, 0), np.float32)
        self._count = 0

    def clear(self) -> None:
        """Forget all trails; the time that comes next follows on none."""
        self.chunks.clear()
        self._time = None

    def extend(
        self,
        now: float,
        robots: list[int],
        xy: NDArray[np.floating],
        put: Collection[int] = (),
    ) -> None:
        """Draw on to where the robots are.

        Args:
            now: Time in s.
            robots: Their numbers.
            xy: Their positions in m, shape (2, N).
            put: Those that did not drive there, but were put there.
        """
        if not robots:  # a page that was opened before its fleet
            return
        xy = xy.astype(np.float32)
        known = bool(self.chunks) and self.chunks[-1].robots == tuple(robots)
        if not known:
            self._new_chunk(robots, xy)
        elif np.abs(xy - self._xy).max(initial=0.0) < _STILL_M:
            self._time = now
            return
        seconds = now - self._time if self._time is not None else 0.0
        self._clock += seconds
        self._time, self._xy = now, xy
        if self._clock - self._sampled > _SAMPLE_S - 1e-6:  # rounding
            self._next_segment(robots)
        unseen = seconds > _LONGEST_GAP_S
        self._draw_to(xy, np.array([unseen or robot in put for robot in robots]))
        while self.chunks and self._clock - self.chunks[0].begin > self.length_s:
            if len(self.chunks) == 1:
                break
            self.chunks.popleft()

    def _new_chunk(self, robots: list[int], xy: Points) -> None:
        points = np.full((len(robots), _SEGMENTS, 2, 3), _HEIGHT_M, np.float32)
        points[..., :2] = xy.T[:, None, None, :]
        self._count += 1
        self.chunks.append(Chunk(self._count, tuple(robots), self._clock, points))
        self._filled, self._sampled = 0, self._clock

    def _next_segment(self, robots: list[int]) -> None:
        last = self.chunks[-1].points[:, self._filled, 1, :2].T
        self._filled, self._sampled = self._filled + 1, self._clock
        if self._filled == _SEGMENTS:
            self._new_chunk(robots, last)
        else:
            self.chunks[-1].points[:, self._filled :, :, :2] = last.T[:, None, None, :]

    def _draw_to(self, xy: Points, put: NDArray[np.bool_]) -> None:
        points = self.chunks[-1].points[:, self._filled :, :, :2]
        points[:, 0, 1] = xy.T
        points[:, 1:] = xy.T[:, None, None, :]
        points[put, 0, 0] = points[put, 0, 1]
