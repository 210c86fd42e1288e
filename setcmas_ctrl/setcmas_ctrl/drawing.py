"""Where the drawing functions of control scripts draw: nowhere, until a process gives a canvas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Sphere:
    """A sphere in the world frame: centre and diameter in m, colour and opacity in [0, 1]."""

    x: float
    y: float
    z: float
    diameter: float
    colour: tuple[float, ...]
    alpha: float


class Canvas(Protocol):
    """Shows spheres to the user."""

    def show(self, robot: int, name: str, sphere: Sphere) -> None:
        """Show a sphere in place of the last one of this robot and name."""

    def extend_trail(self, robot: int, name: str, sphere: Sphere) -> None:
        """Add a sphere to the trail of this robot and name."""


canvas: Canvas | None = None
"""The canvas of this process; None draws nothing."""
