"""Emulated cameras: rendered pictures of the emulated robots, seen by the real detector."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from setcmas_expe.emulation import faults
from setcmas_expe.mocap.camera_file import (
    FIRST_FLOOR_TAG,
    Camera,
    CameraFile,
    CameraPose,
    Lens,
    RobotTags,
)
from setcmas_expe.mocap.camera_poses import TAG_CORNERS, CameraPoses, Picture, tag_family
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.robots.arena import Arena

with needs('camera'):
    import cv2

Greys = NDArray[np.float32]

Seen = tuple[float, int, float, float, float]
"""Time of the exposure in s, index of a robot, x, y in m and heading in rad."""

Faults = Mapping[tuple[str, int], float]
"""When in s the faults began that last, by kind and index of the robot."""

RATE_HZ = 15.0
"""Pictures a second; fewer where this machine takes longer for one."""

_TAGS = RobotTags(size=0.12, height=0.2)
_LENS = Lens((1920, 1080), (1050.0, 1050.0), (959.5, 539.5), (-0.1, 0.02, 0.0, 0.0, 0.0), 0.3)
_REACH = np.array([0.86, 0.48])
"""Half of the floor that a camera sees, relative to its height, less a border for the tags."""
_HIGHEST = 4.0  # m above the tags, which have 31 px there
_BORDER = 0.3  # m, around the arena
_MOST_CAMERAS = 4
_ERROR_M = 0.002
_BUMP = math.radians(2.0)
_DARK = 0.1
_SLOW_HZ = 10.0
_SCALES = {faults.TAG_SIZE: 80 / 120, faults.SHRUNK: 0.97}
_COVERS = {faults.GLARE: 255.0, faults.COVERED: 140.0}
_FASTEST = 2.0  # m/s; what seems faster was moved by a fault

_MODULES, _MARGIN = 8, 1  # black and white squares across a tag, and white ones around it
_TEXTURE_PX = 8
_FINER = 3
"""How many times finer than a pixel tags are drawn, along each axis."""
_BLUR_STEPS = 5
_EXPOSURE_S = 0.01
_NOISE = 4.0  # grey levels, standard deviation
_FLOORS = 4
"""Pictures of the floor, with different noise."""
_DARKEST = 0.6
"""Brightness at the right edge of a picture, relative to the left edge."""
_FLOOR_GREY, _BLACK, _WHITE = 120, 25, 230


@dataclass(frozen=True)
class PlacedTag:
    """A tag: its number, x, y in m, heading in rad, and velocities in m/s and rad/s.

    Attributes:
        scale: Its size relative to what it should be.
        lift: Its height in m above what it should be.
        covered: Grey level of what hides its middle, 255 for glare; None if nothing does.
    """

    number: int
    x: float
    y: float
    heading: float
    vx: float = 0.0
    vy: float = 0.0
    turn: float = 0.0
    scale: float = 1.0
    lift: float = 0.0
    covered: float | None = None

    def after(self, t: float) -> tuple[float, float, float]:
        """Return x, y and heading after t s."""
        return self.x + t * self.vx, self.y + t * self.vy, self.heading + t * self.turn


class PictureRenderer:
    """Renders pictures of one camera, with distortion, blur, noise and uneven light."""

    def __init__(self, camera: Camera, file: CameraFile, seed: int, noise: float = _NOISE) -> None:
        self._camera = camera
        self._tags = file.tags
        self._random = np.random.default_rng(seed)
        width, height = camera.lens.size
        self._light = np.linspace(1.0, _DARKEST, width, dtype=np.float32)
        self._noise = self._random.normal(0, noise, (height, width)).astype(np.float32)
        down, places = -file.tags.height, file.floor_tags.items()
        tags = [PlacedTag(tag, x, y, 0.0, lift=down) for tag, (x, y) in places]
        bare = _pixels(_FLOOR_GREY * self._light + self._noise)
        self._floors = [self._drawn(np.roll(bare, i, axis=1), tags) for i in range(_FLOORS)]

    def picture(self, tags: Sequence[PlacedTag], brightness: float = 1.0) -> Picture:
        """Return a picture of robots' tags, grey, shape (height, width).

        The tags are where they are in the middle of the exposure.
        """
        drawn = self._drawn(self._floors[self._random.integers(_FLOORS)].copy(), tags)
        return drawn if brightness == 1.0 else _pixels(drawn * np.float32(brightness))

    def _drawn(self, picture: Picture, tags: Sequence[PlacedTag]) -> Picture:
        for tag in tags:
            self._draw(picture, tag)
        return picture

    def _draw(self, picture: Picture, tag: PlacedTag) -> None:
        """Draw a tag into a picture, as the mean of several moments of the exposure."""
        half = _EXPOSURE_S / 2 if tag.vx or tag.vy or tag.turn else 0.0
        moments = np.linspace(-half, half, _BLUR_STEPS if half else 1)
        corners = np.array([self._corners(tag, t) for t in moments])
        last = np.array(picture.shape[::-1]) - 1
        low = np.clip(np.floor(corners.min((0, 1))) - 2, 0, last).astype(int)
        size = np.clip(np.ceil(corners.max((0, 1))) + 3, 0, last + 1).astype(int) - low
        if (size < 2).any():
            return
        # The grey of the tag times its coverage, and the coverage.
        layers = np.mean([_warped(tag.number, own - low, size) for own in corners], axis=0)
        here = np.s_[low[1] : low[1] + size[1], low[0] : low[0] + size[0]]
        cover, noise = layers[:, :, 1], self._random.permutation(self._noise[here])
        drawn = layers[:, :, 0] * self._light[here[1]] + cover * noise
        picture[here] = _pixels(picture[here] * (1 - cover) + drawn)
        if tag.covered is not None:
            middle = corners.mean((0, 1)).round().astype(int).tolist()
            cv2.circle(picture, middle, int(0.3 * size.max()), tag.covered, cv2.FILLED)

    def _corners(self, tag: PlacedTag, t: float) -> Floats:
        """Return the pixels (4, 2) of the corners of a tag with its white margin after t s."""
        x, y, heading = tag.after(t)
        side = tag.scale * self._tags.size * (1 + 2 * _MARGIN / _MODULES)
        turned = side * np.exp(1j * heading) * TAG_CORNERS
        height = np.full(4, self._tags.height + tag.lift)
        return self._camera.pixels(np.column_stack([x + turned.real, y + turned.imag, height]))


def _pixels(greys: Greys) -> Picture:
    return np.asarray(np.clip(greys, 0, 255).round(), np.uint8)


def _warped(number: int, corners: Floats, size: NDArray[np.int64]) -> Greys:
    """Return a tag's grey times its coverage, and its coverage, in a part of a picture.

    Args:
        number: The tag.
        corners: Pixels (4, 2) of its corners in the part.
        size: Width and height of the part in px.
    """
    texture = _texture(number)
    side = len(texture)
    # The centre of a pixel has whole coordinates; its edges are half a pixel away.
    edges = np.array([[0, 0], [side, 0], [side, side], [0, side]]) - 0.5
    places = (corners + 0.5) * _FINER - 0.5
    turn = cv2.getPerspectiveTransform(np.float32(edges), np.float32(places))
    layers = cv2.warpPerspective(texture, turn, (size * _FINER).tolist(), flags=cv2.INTER_LINEAR)
    return np.asarray(cv2.resize(layers, size.tolist(), interpolation=cv2.INTER_AREA), np.float32)


@lru_cache(maxsize=64)
def _texture(number: int) -> Greys:
    """Return a tag with its white margin: grey and coverage, shape (side, side, 2)."""
    bits = np.pad(tag_family().generateImageMarker(number, _MODULES), _MARGIN, constant_values=255)
    grey = np.where(bits > 0, _WHITE, _BLACK).astype(np.float32)
    grey = np.kron(grey, np.ones((_TEXTURE_PX, _TEXTURE_PX), np.float32))
    return np.dstack([grey, np.ones_like(grey)])


def cameras_over(arena: Arena, tilt: float = 0.0) -> CameraFile:
    """Return the cameras of an emulated lab: as few, and as low, as see the whole arena.

    They look down, but for a tilt in rad.

    Raises:
        SetcmasError: The arena is too large for four cameras.
    """
    inner = np.array([arena.xmax - arena.xmin, arena.ymax - arena.ymin])
    sides = inner + 2 * _BORDER
    largest = 2 * _HIGHEST * _REACH
    counts = np.maximum(1, np.ceil(sides / largest)).astype(int)
    if counts.prod() > _MOST_CAMERAS:
        raise SetcmasError(
            f'{_MOST_CAMERAS} emulated cameras do not see the whole arena of {inner[0]:g} x '
            f'{inner[1]:g} m (each sees {largest[0]:.1f} x {largest[1]:.1f} m); '
            'add a smaller --arena, such as --arena=-3,3,-3,3'
        )
    cell = sides / counts
    height = _TAGS.height + float((cell / 2 / _REACH).max())
    corner = np.array([arena.xmin, arena.ymin]) - _BORDER
    cameras, places = [], []
    for number, at in enumerate(np.ndindex(*counts), 1):
        middle = corner + cell * (np.array(at) + 0.5)
        pose = CameraPose((*middle.tolist(), height), (math.pi + tilt, 0.0, 0.0), _ERROR_M)
        cameras.append(Camera(f'camera{number}', 'emulated', _LENS, pose))
        turns = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        places += (middle + 0.5 * (cell - 0.3) * turns).tolist()
    floor_tags = {number: tuple(place) for number, place in enumerate(places, FIRST_FLOOR_TAG)}
    return CameraFile(_TAGS, tuple(cameras), floor_tags)


class EmulatedCamera:
    """Takes pictures in a thread of its own, so that the lab's steps go on meanwhile."""

    def __init__(self, arena: Arena, nb_robots: int, seed: int) -> None:
        """Put cameras over an arena.

        Raises:
            SetcmasError: The arena is too large, or OpenCV is not installed.
        """
        cv2.setNumThreads(1)  # other threads would wait on the cores that robots need
        self.file = cameras_over(arena)
        self.news: list[str] = []
        """What the cameras' operator should know, in words, not yet taken."""
        self._arena = arena
        self._nb_robots = nb_robots
        self._seed = seed
        self._put_up(is_bumped=False)
        self._thread = ThreadPoolExecutor(max_workers=1)
        self._pending: Future[list[Seen]] | None = None
        self._taken = -math.inf
        self._tags: list[PlacedTag] = []

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
        tags = [self._tag(index, since, now, *pose) for index, pose in enumerate(poses.T.tolist())]
        moving = _with_velocities(tags, self._tags or tags, now - self._taken)
        self._tags, self._taken = tags, now
        self._pending = self._thread.submit(self._look, moving, kinds, now)
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
            lift=-_TAGS.height if faults.FALLEN in kinds else lift,
            covered=next((_COVERS[kind] for kind in kinds & _COVERS.keys()), None),
        )

    def _put_up(self, is_bumped: bool) -> None:
        """Hang the cameras; calibrate them unless they were bumped."""
        self._is_bumped = is_bumped
        self._renderers = {
            one.name: PictureRenderer(one, self.file, self._seed + index)
            for index, one in enumerate(cameras_over(self._arena, _BUMP * is_bumped).cameras)
        }
        if not is_bumped:
            self._poses = CameraPoses(self.file, self._nb_robots)

    def _look(self, tags: Sequence[PlacedTag], kinds: set[str], now: float) -> list[Seen]:
        if self._is_bumped != (faults.BUMPED in kinds):
            self._put_up(not self._is_bumped)
        brightness = _DARK if faults.DARK in kinds else 1.0
        found: dict[int, Seen] = {}
        for camera, renderer in self._renderers.items():
            poses = self._poses.look(camera, now, renderer.picture(tags, brightness))
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
        is_real = math.hypot(vx, vy) < _FASTEST
        moving.append(replace(tag, vx=vx, vy=vy, turn=turn) if is_real else tag)
    return moving
