"""Drawing for control scripts: one marker, updated on /tb3_i/<marker_name>."""

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
    """Show a sphere; the next call with the same robot and name moves it.

    Offline runs write it to drawings.csv.

    Args:
        x: Position of the centre in the world frame, in m.
        y: As x.
        z: As x.
        robotNo: Number of the marker's robot.
        color: Red, green and blue, each in [0, 1].
        scale: Diameter in m.
        marker_name: Last part of the topic name, such as 'wp_ref'.
        alpha: Opacity in [0, 1].
    """
    draw(robotNo, marker_name, sphere(x, y, z, scale, color, alpha))
