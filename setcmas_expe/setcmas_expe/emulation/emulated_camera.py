"""Emulated cameras: pictures of the emulated robots, seen by the real detector."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from setcmas_expe.camera.camera_file import Camera, CameraFile, CameraPose, Lens, RobotTags
from setcmas_expe.camera.camera_poses import CameraPoses
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.picture_rendering import PictureQuality, PictureRenderer, PlacedTag
from setcmas_expe.camera.tag_sheets import FIRST_FLOOR_TAG
from setcmas_expe.emulation import faults
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Arena

RATE_HZ = 15.0
"""Pictures a second; fewer where this machine takes longer for one."""
TAG_HEIGHT = 0.2
"""Height of the robots' tags in m."""

_TAG_SIZE = 0.12  # m
_LENS = Lens((1920, 1080), (1050.0, 1050.0), (959.5, 539.5), (-0.1, 0.02, 0.0, 0.0, 0.0), 0.3)
_REACH = (0.86, 0.48)
"""Half of the floor that a camera sees, relative to its height, less a border for the tags."""
_HIGHEST = 4.0  # m above the tags; tags have 31 px there
_BORDER = 0.3  # m, around the arena
_MOST_CAMERAS = 4
_ERROR_M = 0.002
_BUMP = math.radians(2.0)
_DARK = 0.1
_SLOW_HZ = 10.0
_SCALES = {faults.TAG_SIZE: 80 / 120, faults.SHRUNK: 0.97}
_COVERS = {faults.GLARE: 255.0, faults.COVERED: 140.0}
_FASTEST = 2.0  # m/s; what seems faster was moved by a fault

Seen = tuple[float, int, float, float, float]
"""Time of the exposure in s, index of a robot, x, y in m and heading in rad."""

Faults = Mapping[tuple[str, int], float]
"""When in s the faults began that last, by kind and index of the robot."""


def cameras_over(arena: Arena, tilt: float = 0.0) -> CameraFile:
    """Return the cameras of an emulated lab: as few, and as low, as see the whole arena.

    They look down, but for a tilt in rad.

    Raises:
        SetcmasError: The arena is too large for four cameras.
    """
    sides = np.array([arena.xmax - arena.xmin, arena.ymax - arena.ymin]) + 2 * _BORDER
    counts = np.maximum(1, np.ceil(sides / (2 * _HIGHEST * np.array(_REACH)))).astype(int)
    if counts.prod() > _MOST_CAMERAS:
        largest = 2 * _HIGHEST * np.array(_REACH)
        raise SetcmasError(
            f'{_MOST_CAMERAS} emulated cameras do not see the whole arena of {sides[0] - 0.6:g} x '
            f'{sides[1] - 0.6:g} m (each sees {largest[0]:.1f} x {largest[1]:.1f} m); '
            'add a smaller --arena, such as --arena=-3,3,-3,3'
        )
    cell = sides / counts
    height = TAG_HEIGHT + float((cell / 2 / np.array(_REACH)).max())
    corner = np.array([arena.xmin, arena.ymin]) - _BORDER
    middles = [corner + cell * (np.array(at) + 0.5) for at in np.ndindex(*counts)]
    places: list[tuple[float, ...]] = []
    for middle in middles:
        for turn in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            x, y = middle + 0.5 * (cell - 0.3) * turn
            places.append((float(x), float(y)))
    cameras = tuple(
        Camera(
            f'camera{number}',
            'emulated',
            _LENS,
            CameraPose((float(x), float(y), height), (math.pi + tilt, 0.0, 0.0), _ERROR_M),
        )
        for number, (x, y) in enumerate(middles, 1)
    )
    floor_tags = dict(enumerate(places, FIRST_FLOOR_TAG))
    return CameraFile(RobotTags(_TAG_SIZE, TAG_HEIGHT), cameras, floor_tags)


class EmulatedCamera:
    """Takes pictures in a thread of its own, so that the lab's steps go on meanwhile."""

    def __init__(self, arena: Arena, nb_robots: int, seed: int) -> None:
        """Put cameras over an arena.

        Raises:
            SetcmasError: The arena is too large, or OpenCV is not installed.
        """
        self.file = cameras_over(arena)
        self._arena = arena
        self._nb_robots = nb_robots
        self._seed = seed
        self._renderers = self._put_up(bumped=False)
        self._bumped: list[PictureRenderer] = []
        self._poses = CameraPoses(self.file, nb_robots)
        self._thread = ThreadPoolExecutor(max_workers=1)
        self._pending: Future[list[Seen]] | None = None
        self._taken = -math.inf
        self._tags: list[PlacedTag] = []
        self._was_bumped = False
        self.news: list[str] = []
        """What the cameras' operator should know, in words, not yet taken."""

    def expose(self, poses: Floats, since: Faults, now: float) -> list[Seen]:
        """Take pictures at a time now (s), if it is time; return what earlier ones show.

        Args:
            poses: Rows x, y in m and theta in rad, shape (3, N).
            since: Faults of the robots' tags and of the cameras.
            now: Time in s.
        """
        seen: list[Seen] = []
        if self._pending and self._pending.done():
            seen, self._pending = self._pending.result(), None
            self.news += self._poses.news()
        kinds = {kind for kind, _ in since}
        rate = _SLOW_HZ if faults.TEN_FRAMES in kinds else RATE_HZ
        if self._pending or faults.STUCK in kinds or now - self._taken < 0.98 / rate:
            return seen
        is_bumped = faults.BUMPED in kinds
        if self._was_bumped and not is_bumped:  # calibrated again
            self._poses = CameraPoses(self.file, self._nb_robots)
        self._was_bumped = is_bumped
        tags = [self._tag(index, since, now, *pose) for index, pose in enumerate(poses.T.tolist())]
        moving = _with_velocities(tags, self._tags or tags, now - self._taken)
        self._tags, self._taken = tags, now
        brightness = _DARK if faults.DARK in kinds else 1.0
        self._pending = self._thread.submit(self._look, moving, is_bumped, brightness, now)
        return seen

    def _tag(
        self, index: int, since: Faults, now: float, x: float, y: float, theta: float
    ) -> PlacedTag:
        """Return the tag of a robot under its faults."""
        kinds = {kind for kind, robot in since if robot == index}
        lift = faults.lifted(now - since[faults.LIFT, index]) if faults.LIFT in kinds else 0.0
        return PlacedTag(
            (index + (faults.TWINS in kinds)) % self._nb_robots + 1,
            x,
            y,
            theta,
            scale=min((_SCALES[kind] for kind in kinds & _SCALES.keys()), default=1.0),
            lift=-TAG_HEIGHT if faults.FALLEN in kinds else lift,
            covered=next((_COVERS[kind] for kind in kinds & _COVERS.keys()), None),
        )

    def _put_up(self, bumped: bool) -> list[PictureRenderer]:
        cameras = cameras_over(self._arena, _BUMP if bumped else 0.0).cameras
        return [
            PictureRenderer(FloorProjection(one), self.file, PictureQuality(), self._seed + index)
            for index, one in enumerate(cameras)
        ]

    def _look(
        self, tags: Sequence[PlacedTag], is_bumped: bool, brightness: float, now: float
    ) -> list[Seen]:
        if is_bumped and not self._bumped:
            self._bumped = self._put_up(bumped=True)
        renderers = self._bumped if is_bumped else self._renderers
        found: dict[int, Seen] = {}
        for camera, renderer in zip(self.file.cameras, renderers, strict=True):
            picture = renderer.picture(tags, brightness)
            poses = self._poses.look(camera.name, now, picture)
            found |= {robot: (now, robot - 1, *pose) for robot, pose in poses.items()}
        return list(found.values())


def _with_velocities(
    tags: Sequence[PlacedTag], before: Sequence[PlacedTag], period: float
) -> list[PlacedTag]:
    """Return tags with the velocities since they were at other places, so that they blur."""
    moving = []
    for tag, old in zip(tags, before, strict=True):
        vx, vy = (tag.x - old.x) / period, (tag.y - old.y) / period
        turn = math.remainder(tag.heading - old.heading, math.tau) / period
        is_real = math.hypot(vx, vy) < _FASTEST and math.hypot(vx, vy) + abs(turn) > 1e-6
        moving.append(replace(tag, vx=vx, vy=vy, turn=turn) if is_real else tag)
    return moving
