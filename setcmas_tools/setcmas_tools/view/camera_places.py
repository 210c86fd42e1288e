"""Where a camera has to be so that a square of ground fills the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

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
        covered: Share of the width, on the right, that the panel covers.
    """
    back = _DIRECTIONS[name] / np.linalg.norm(_DIRECTIONS[name])
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    corners = half_m * np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
    tall = np.tan(0.5 * FOV)
    wide = tall * aspect * (1.0 - covered)
    # A corner at depth d - c.back is seen if |c.right| <= wide * depth and |c.up| <= tall * depth.
    distances = np.maximum(abs(corners @ right) / wide, abs(corners @ up) / tall)
    distance = float(np.max(distances + corners @ back))
    target = right * distance * tall * aspect * covered
    return target + back * distance, target
