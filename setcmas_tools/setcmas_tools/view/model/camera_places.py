"""Places of a camera from which a square of ground fills the picture."""

from __future__ import annotations

import numpy as np

from setcmas_simu.arrays import Floats

FOV = 0.6
"""Vertical field of view of the cameras, in rad."""

TOP, SIDE = 'Top', '3D'
VIEWS = (SIDE, TOP)

_SEEN = np.array([
    [1.02, 1.02, 0], [1.02, -1.02, 0], [-1.02, 1.02, 0], [-1.02, -1.02, 0],  # the ground
    [-0.75, -1.1, 0], [0.75, -1.1, 0], [-1.13, -0.75, 0], [-1.13, 0.75, 0],  # its metres
])  # fmt: skip
_HALVINGS = 40
_DIRECTIONS = {
    TOP: np.array([0.0, -1e-3, 1.0]),  # not quite from above, where up would have no direction
    SIDE: np.array([-0.22, -0.92, 1.0]),
}
"""From the ground to the camera."""


def place(
    name: str,
    half_m: float,
    aspect: float,
    covered: float,
    covered_below: float = 0.0,
    beside_m: float = 0.0,
) -> tuple[Floats, Floats]:
    """Return camera place and the point it looks at, in m, such that a square is seen.

    With it the metres are, which stand on its left and in front of it.

    Args:
        name: One of `VIEWS`.
        half_m: Half the side of the square around the origin, in m.
        aspect: Width of the picture over its height.
        covered: Share of the width, on the right, that the panel covers; less than half.
        covered_below: Share of the height, at the bottom, that a panel covers; less than half.
        beside_m: How far to the right, in m, a second square is that is seen, too; 0 for none.
    """
    back = _DIRECTIONS[name] / np.linalg.norm(_DIRECTIONS[name])
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    corners = np.vstack([half_m * _SEEN, half_m * _SEEN + [beside_m, 0.0, 0.0]])
    tall = np.tan(0.5 * FOV)
    wide = tall * aspect
    towards = corners @ back
    sideways = _Slab(corners @ right, towards, wide, wide * (1.0 - 2.0 * covered))
    upwards = _Slab(corners @ up, towards, tall * (1.0 - 2.0 * covered_below), tall)
    distance = max(sideways.distance, upwards.distance)
    seen = right * sideways.middle(distance) + up * upwards.middle(distance)
    target = seen - back * seen[2] / back[2]  # on the ground, where the user turns around it
    return seen + back * distance, target


class _Slab:
    """What a camera sees between two edges of its picture.

    From a distance d, and moved across by s, it sees the points with
    -low <= (across - s) / (d - towards) <= high.

    Attributes:
        distance: The least one from which all points are seen.
    """

    def __init__(self, across: Floats, towards: Floats, low: float, high: float) -> None:
        """Take points, and the tangents of the angles to the edges."""
        self._across, self._towards = across, towards
        self._low, self._high = low, high
        self._from = float(np.max(towards - across / low))
        self._to = float(np.max(towards + across / high))
        self.distance = (low * self._from + high * self._to) / (low + high)

    def middle(self, distance: float) -> float:
        """Return the s from which there is as much free on both sides of the picture."""
        depth = distance - self._towards
        low, high = -self._high * (distance - self._to), self._low * (distance - self._from)
        for _ in range(_HALVINGS):  # what is nearer moves faster: no formula tells it
            s = (low + high) / 2
            places = (self._across - s) / depth
            if self._high - places.max() < places.min() + self._low:
                low = s
            else:
                high = s
        return s
