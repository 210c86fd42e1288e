"""Shapes of a visualization_msgs/Marker, as the scene draws them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics

ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST = range(8)
POINTS, TEXT = 8, 9
"""Values of visualization_msgs/Marker.type."""

LINES = 'lines'
LABEL = 'label'
_BODIES = {
    ARROW: 'arrow',
    CUBE: 'cube',
    SPHERE: 'sphere',
    CYLINDER: 'cylinder',
    CUBE_LIST: 'cube',
    SPHERE_LIST: 'sphere',
    POINTS: 'cube',
}
SOLIDS = ('arrow', 'cube', 'sphere', 'cylinder')
"""Shapes that are drawn as bodies, the rows of `Shape.rows` telling where."""

_MOST_POINTS = 5000  # of one marker
_LEAST_M = 0.01
_FALLBACK_M = 0.15


@dataclass(frozen=True)
class Shape:
    """What one marker looks like.

    Attributes:
        kind: One of `SOLIDS`, `LINES` or `LABEL`.
        robot: In whose frame it is; 0 for the world.
        rows: Solids: x, y, z (m), quaternion w, x, y, z, sizes along x, y, z (m), red, green,
            blue, alpha from 0 to 1, shape (n, 14). Lines: segments as x, y, z of both ends, and
            red, green, blue of both, shape (n, 12). Label: as a solid, one row.
        text: Of a label.
        thickness: Of lines, in m.
    """

    kind: str
    robot: int
    rows: Floats
    text: str = ''
    thickness: float = 0.02


def shape(marker: Any) -> Shape | None:
    """Return what a Marker message looks like; None if there is nothing that can be shown.

    Args:
        marker: A visualization_msgs/Marker; types that are not known are shown as a cube.
    """
    pose, scale, colour = marker.pose, marker.scale, marker.color
    q = pose.orientation
    quaternion = np.array([q.w, q.x, q.y, q.z])
    norm = np.linalg.norm(quaternion)
    quaternion = quaternion / norm if norm > 1e-6 else np.array([1.0, 0.0, 0.0, 0.0])
    place = np.array([pose.position.x, pose.position.y, pose.position.z])
    sizes = np.array([scale.x, scale.y, scale.z])
    rgba = np.clip([colour.r, colour.g, colour.b, colour.a], 0.0, 1.0)
    robot = topics.robot_of(f'/{marker.header.frame_id.strip("/")}/') or 0
    points = np.array([(p.x, p.y, p.z) for p in marker.points[:_MOST_POINTS]]).reshape(-1, 3)
    if marker.type in (LINE_STRIP, LINE_LIST):
        return _lines(marker, robot, place + rotate(quaternion, points), rgba)
    if marker.type == ARROW and len(points) >= 2:
        quaternion, place, sizes = _from_tail_to_tip(points[0], points[1], sizes, place)
        centres = place[None]
    elif marker.type in (CUBE_LIST, SPHERE_LIST, POINTS):
        centres = place + rotate(quaternion, points)
        sizes = sizes if marker.type != POINTS else np.array([scale.x, scale.y, scale.x])
    else:
        centres = place[None]
    if marker.type not in _BODIES and marker.type != TEXT:
        sizes = np.full(3, _FALLBACK_M)
    sizes = np.maximum(np.abs(sizes), _LEAST_M if marker.type != TEXT else 0.0)
    rows = np.empty((len(centres), 14))
    rows[:, :3], rows[:, 3:7], rows[:, 7:10], rows[:, 10:] = centres, quaternion, sizes, rgba
    if len(marker.colors) == len(rows) > 1:
        rows[:, 10:] = [(c.r, c.g, c.b, c.a) for c in marker.colors]
    if not len(rows) or not np.isfinite(rows).all():
        return None
    if marker.type == TEXT:
        return Shape(LABEL, robot, rows, marker.text)
    return Shape(_BODIES.get(marker.type, 'cube'), robot, rows)


def rotate(quaternion: Floats, points: Floats) -> Floats:
    """Return points, shape (n, 3), turned by a unit quaternion (w, x, y, z)."""
    w, v = quaternion[0], quaternion[1:]
    result: Floats = points + 2 * np.cross(v, np.cross(v, points) + w * points)
    return result


def _lines(marker: Any, robot: int, points: Floats, rgba: Floats) -> Shape | None:
    strip = marker.type == LINE_STRIP
    begins, ends = (points[:-1], points[1:]) if strip else (points[:-1:2], points[1::2])
    if not len(begins) or not np.isfinite(points).all():
        return None
    colours = np.tile(rgba[:3], (len(points), 1))
    if len(marker.colors) == len(points):
        colours = np.clip([(c.r, c.g, c.b) for c in marker.colors], 0.0, 1.0)
    ends_colours = (colours[:-1], colours[1:]) if strip else (colours[:-1:2], colours[1::2])
    rows = np.column_stack([begins, ends, *ends_colours])
    return Shape(LINES, robot, rows, thickness=max(float(marker.scale.x), _LEAST_M))


def _from_tail_to_tip(
    tail: Floats, tip: Floats, sizes: Floats, place: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return quaternion, place and sizes of an arrow that two points tell."""
    along = tip - tail
    length = float(np.linalg.norm(along))
    x, y, z = along / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    # The shortest turn from the x axis: w + i q is proportional to (1 + cos, axis * sin).
    quaternion = np.array([1.0 + x, 0.0, -z, y]) if x > -0.999999 else np.array([0, 0, 0, 1.0])
    quaternion = quaternion / np.linalg.norm(quaternion)
    return quaternion, place + tail, np.array([length, sizes[1], sizes[1]])
