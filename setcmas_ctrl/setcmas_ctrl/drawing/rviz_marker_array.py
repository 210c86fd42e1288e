"""Drawing for control scripts: a trail of markers on /tb3_i/<marker_name>."""

from __future__ import annotations

from collections.abc import Sequence

from setcmas_ctrl.drawing.canvas import draw, sphere


def publish_marker(
    x: float,
    y: float,
    z: float,
    robotNo: int,
    color: Sequence[float] = (0.25, 0.25, 0.25),
    scale: float = 0.2,
    marker_name: str = 'ref',
    alpha: float = 0.5,
) -> None:
    """Add a sphere to a trail; the trail keeps its last 500 spheres.

    Arguments as for `rviz_marker.publish_marker`.
    """
    draw(robotNo, marker_name, sphere(x, y, z, scale, color, alpha), trail=True)
