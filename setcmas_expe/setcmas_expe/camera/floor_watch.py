"""Watch on the floor tags: a camera that was moved after its calibration sees them elsewhere."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_simu.arrays import Floats

MOST_SHIFT_M = 0.03
"""Distance in m from which a floor tag is away from its place."""
LONGEST_HIDDEN_S = 1.0
"""Time in s without any floor tag after which a camera cannot be trusted."""
_SURE_AFTER_S = 0.2


class FloorWatch:
    """Compares the floor tags that a camera sees with their places.

    Attributes:
        fault: Why the camera's poses must not be used, in words; empty while they may. It stays
            until the camera is calibrated again.
    """

    def __init__(
        self, projection: FloorProjection, floor_tags: Mapping[int, tuple[float, ...]], t: float
    ) -> None:
        self.fault = ''
        self._projection = projection
        self._places = {
            tag: np.array(place)
            for tag, place in floor_tags.items()
            if projection.sees(np.array([*place, 0.0]))
        }
        self._last_seen = t
        self._last_right = t

    def look(self, t: float, corners: Mapping[int, Floats]) -> None:
        """Check the tags (4, 2) in px that the camera saw at t in s."""
        shifts = {tag: self._shift(tag, corners[tag]) for tag in self._places if tag in corners}
        wrong = {tag: shift for tag, shift in shifts.items() if not shift <= MOST_SHIFT_M}
        self._last_seen = t if shifts else self._last_seen
        self._last_right = self._last_right if wrong else t
        if not self.fault and wrong and t - self._last_right >= _SURE_AFTER_S:
            self.fault = self._moved(wrong, len(shifts))
        if not self.fault and t - self._last_seen >= LONGEST_HIDDEN_S:
            name = self._projection.camera.name
            self.fault = f'camera {name} sees no floor tag; uncover one that it was calibrated to'

    def _shift(self, tag: int, corners: Floats) -> float:
        """Return how far in m a tag is from its place; NaN if the camera does not look down."""
        centre = self._projection.points(corners, 0.0).mean(axis=0)
        return float(np.hypot(*(centre - self._places[tag])))

    def _moved(self, wrong: Mapping[int, float], nb_seen: int) -> str:
        """Return which of the tags and the camera was moved."""
        name = self._projection.camera.name
        tag = max(wrong, key=lambda one: wrong[one])
        where = f'{1e3 * wrong[tag]:.0f} mm from its place'
        if len(wrong) == 1 and nb_seen > 1:
            return f'floor tag {tag} is {where} for camera {name}; put it back'
        return f'camera {name} was moved: floor tag {tag} is {where}; calibrate the floor again'
