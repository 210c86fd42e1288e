"""Poses of robots from the pictures of cameras, fused without a jump; watch on the floor tags."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from setcmas_expe.camera.camera_file import CameraFile
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.tag_detection import Picture, TagDetector, TagPose, tag_poses
from setcmas_simu.arrays import Floats

OLDEST_S = 0.25
"""Age in s from which a camera's pose is not used."""
MOST_APART_M = 0.15
"""Distance in m between what two cameras see from which neither is believed."""
MOST_SHIFT_M = 0.03
"""Distance in m from which a floor tag is away from its place."""
LONGEST_HIDDEN_S = 1.0
"""Time in s without any floor tag after which a camera cannot be trusted."""
_SURE_AFTER_S = 0.2
_EDGE_PX = 100.0
"""Distance from the picture's edge in px up to which a camera's weight falls."""
_LEAST_WEIGHT = 1e-3

Pose = tuple[float, float, float]
"""x, y in m and heading in rad."""


class CameraPoses:
    """Finds the robots in the pictures of the cameras of a file.

    Attributes:
        fault: Why no pose may be used, in words; empty while they may. It stays until the cameras
            are calibrated again.
        corners: Corners (4, 2) in px of the tags in the last picture of each camera.
    """

    def __init__(self, file: CameraFile, nb_robots: int) -> None:
        self.fault = ''
        self.corners: dict[str, dict[int, Floats]] = {}
        self._file = file
        self._nb_robots = nb_robots
        self._detector = TagDetector()
        self._projections = {one.name: FloorProjection(one) for one in file.cameras}
        self._watches: dict[str, FloorWatch] = {}
        self._fused = FusedPoses()
        self._newest: dict[int, float] = {}
        self._reasons: dict[str, dict[int, str]] = {}
        self._told: set[str] = set()

    @property
    def reasons(self) -> dict[int, str]:
        """Why robots whose tag is seen have no pose, in words."""
        return {robot: why for seen in self._reasons.values() for robot, why in seen.items()}

    def news(self) -> list[str]:
        """Return the fault and the reasons that were not returned before."""
        lines = {self.fault} - {''} | {f'robot {i}: {why}' for i, why in self.reasons.items()}
        new = sorted(lines - self._told)
        self._told = lines
        return new

    def look(self, camera: str, t: float, picture: Picture) -> dict[int, Pose]:
        """Return x, y in m and heading in rad at t of the robots in a picture.

        Args:
            camera: Name of a camera in the file.
            t: Time of the exposure in s, on a clock that all cameras share.
            picture: Its picture, in the size of its lens.
        """
        projection = self._projections[camera]
        if camera not in self._watches:
            self._watches[camera] = FloorWatch(projection, self._file.floor_tags, t)
        watch = self._watches[camera]
        corners, twice = self._detector.corners(picture)
        self.corners[camera] = corners
        watch.look(t, corners)
        self.fault = self.fault or watch.fault
        seen, reasons = tag_poses(projection, self._file.tags, corners, self._nb_robots)
        reasons |= dict.fromkeys(twice, 'two tags have its number; each robot needs its own')
        found = {}
        for robot, pose in seen.items():
            self._fused.add(robot, camera, t, pose)
            fused = self._fused.pose(robot, t)
            if fused is None:
                reasons[robot] = 'two cameras see its number at different places'
            elif t >= self._newest.get(robot, -math.inf):
                self._newest[robot] = t
                found[robot] = fused
        self._reasons[camera] = reasons
        return found if watch.is_right and not self.fault else {}


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
        """Return x, y in m and heading in rad of a robot at t in s.

        None if no camera sees it, or if two see it far apart: two tags with its number.
        """
        tracks = [seen for (number, _), seen in self._seen.items() if number == robot]
        parts = [(_weight(seen[-1], t), *_extrapolated(seen, t)) for seen in tracks]
        parts = [part for part in parts if part[0] > 0]
        if not parts:
            return None
        total = sum(part[0] for part in parts)
        x = sum(weight * x for weight, x, _, _ in parts) / total
        y = sum(weight * y for weight, _, y, _ in parts) / total
        if max(math.hypot(part[1] - x, part[2] - y) for part in parts) > MOST_APART_M / 2:
            return None
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


class FloorWatch:
    """Compares the floor tags that a camera sees with their places.

    Attributes:
        fault: Why the camera's poses must not be used, in words; empty while they may.
        is_right: Whether the floor tags in the last picture were in their places.
    """

    def __init__(
        self, projection: FloorProjection, floor_tags: Mapping[int, tuple[float, ...]], t: float
    ) -> None:
        self.fault = ''
        self.is_right = True
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
        self.is_right = not wrong
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
