"""Fusion of the poses that several cameras see of one robot, without a jump between cameras."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from setcmas_expe.camera.tag_detection import TagPose

OLDEST_S = 0.25
"""Age in s from which a camera's pose is not used."""
_EDGE_PX = 100.0
"""Distance from the picture's edge in px up to which a camera's weight falls."""
_LEAST_WEIGHT = 1e-3


@dataclass(frozen=True)
class _Seen:
    t: float
    pose: TagPose


class FusedPoses:
    """Weighs the poses that cameras see, each extrapolated to the same time.

    A camera's weight falls to nearly 0 towards the edge of its picture and as its pose becomes
    old, so that a robot that leaves one camera, or a camera that stops, moves the mean gradually.
    """

    def __init__(self) -> None:
        self._seen: dict[tuple[int, str], deque[_Seen]] = {}

    def add(self, robot: int, camera: str, t: float, pose: TagPose) -> None:
        """Add a pose seen by a camera, exposed at t in s of this machine's clock.

        A pose that is not newer than the last one from this camera is dropped.
        """
        seen = self._seen.setdefault((robot, camera), deque(maxlen=2))
        if not seen or t > seen[-1].t:
            seen.append(_Seen(t, pose))

    def pose(self, robot: int, t: float) -> tuple[float, float, float] | None:
        """Return x, y in m and heading in rad of a robot at t in s; None if no camera sees it."""
        tracks = [seen for (number, _), seen in self._seen.items() if number == robot]
        parts = [(_weight(seen[-1], t), *_extrapolated(seen, t)) for seen in tracks]
        parts = [part for part in parts if part[0] > 0]
        if not parts:
            return None
        total = sum(part[0] for part in parts)
        x = sum(weight * x for weight, x, _, _ in parts) / total
        y = sum(weight * y for weight, _, y, _ in parts) / total
        sine = sum(weight * math.sin(heading) for weight, _, _, heading in parts)
        cosine = sum(weight * math.cos(heading) for weight, _, _, heading in parts)
        return x, y, math.atan2(sine, cosine)


def _weight(seen: _Seen, t: float) -> float:
    """Return the weight of a camera's last pose at a time t in s; 0 if it is too old."""
    freshness = 1 - abs(t - seen.t) / OLDEST_S
    if freshness <= 0:
        return 0.0
    return freshness * max(_LEAST_WEIGHT, min(1.0, seen.pose.edge / _EDGE_PX))


def _extrapolated(seen: deque[_Seen], t: float) -> tuple[float, float, float]:
    """Return x, y and heading at a time t in s, with the velocity between the last two poses."""
    last, before = seen[-1], seen[0]
    pose, former = last.pose, before.pose
    if not 0 < last.t - before.t <= OLDEST_S:
        return pose.x, pose.y, pose.heading
    ahead = (t - last.t) / (last.t - before.t)
    turned = math.remainder(pose.heading - former.heading, math.tau)
    return (
        pose.x + ahead * (pose.x - former.x),
        pose.y + ahead * (pose.y - former.y),
        math.remainder(pose.heading + ahead * turned, math.tau),
    )
