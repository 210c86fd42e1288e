"""Places of a camera from which a square of ground fills the picture."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats

FOV = 0.6
"""Vertical field of view of the cameras, in rad."""

TOP, SIDE = 'Top', '3D'
VIEWS = (SIDE, TOP)

_DIRECTIONS = {
    TOP: np.array([0.0, -1e-3, 1.0]),  # not quite from above, where up would have no direction
    SIDE: np.array([-0.22, -0.92, 0.75]),
}
"""From the ground to the camera."""


def place(name: str, half_m: float, aspect: float, covered: float) -> tuple[Floats, Floats]:
    """Return camera place and the point it looks at, in m, such that a square is seen.

    Args:
        name: One of `VIEWS`.
        half_m: Half the side of the square around the origin, in m.
        aspect: Width of the picture over its height.
        covered: Share of the width, on the right, that the panel covers; less than half.
    """
    back = _DIRECTIONS[name] / np.linalg.norm(_DIRECTIONS[name])
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    corners = half_m * np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
    tall = np.tan(0.5 * FOV)
    wide = tall * aspect
    towards = corners @ back
    sideways = _Slab(corners @ right, towards, wide, wide * (1.0 - 2.0 * covered))
    upwards = _Slab(corners @ up, towards, tall, tall)
    distance = max(sideways.distance, upwards.distance)
    seen = right * sideways.middle(distance) + up * upwards.middle(distance)
    target = seen - back * seen[2] / back[2]  # on the ground, where the user turns around it
    return seen + back * distance, target


class _Slab:
    """What a camera sees between two edges of its picture.

    From a distance d, and moved across by s, it sees the points with
    -low * (d - towards) <= across - s <= high * (d - towards).

    Attributes:
        distance: The least one from which all points are seen.
    """

    def __init__(self, across: Floats, towards: Floats, low: float, high: float) -> None:
        """Take points, and the tangents of the angles to the edges."""
        self._low, self._high = low, high
        self._from = float(np.max(towards - across / low))
        self._to = float(np.max(towards + across / high))
        self.distance = (low * self._from + high * self._to) / (low + high)

    def middle(self, distance: float) -> float:
        """Return the s halfway between the two that just let all points be seen."""
        return (self._low * (distance - self._from) - self._high * (distance - self._to)) / 2
