"""Cameras over the floor: lens, pose and projection of each, and the file that holds them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.yaml_entries import Entry, read_entries, write_yaml

with needs('camera'):
    import cv2

CORNER_ERROR_PX = 0.15
"""Standard deviation of a detected corner in px, as measured in rendered pictures."""

_LAST_TAG = 586  # of the family 36h11; the first is 0
_MOST_PX, _MOST_M = 20_000, 100


@dataclass(frozen=True)
class RobotTags:
    """Tags on the robots: side of the black square and height above the floor in m."""

    size: float
    height: float


@dataclass(frozen=True)
class Lens:
    """Pinhole camera with radial and tangential distortion.

    Attributes:
        size: Width and height of the picture in px.
        focal: Focal lengths in px.
        centre: Principal point in px; the centre of the first pixel is (0, 0).
        distortion: k1, k2, p1, p2, k3, as in OpenCV.
        error: Root mean square error of the calibration in px.
    """

    size: tuple[int, int]
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, ...]
    error: float

    @property
    def matrix(self) -> Floats:
        """The camera matrix, shape (3, 3)."""
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class CameraPose:
    """Pose of a camera over the floor.

    Attributes:
        position: x, y and z in m; the floor has z = 0.
        rotation: Rotation vector in rad from the floor's axes to the camera's (x to the right of
            the picture, y down, z forward).
        error: Standard deviation of positions on the floor that the calibration leaves, in m.
    """

    position: tuple[float, ...]
    rotation: tuple[float, ...]
    error: float


@dataclass(frozen=True)
class Accuracy:
    """Expected standard deviations of a pose: position in m, heading in rad, and the tag in px."""

    position: float
    heading: float
    pixels_per_tag: float


@dataclass(frozen=True)
class Camera:
    """A camera, which maps points above the floor to pixels and back.

    Attributes:
        name: Its name.
        source: Where its pictures come from: number or path of a device, a video file, a folder
            of pictures, or a topic with images or compressed images.
        lens: Its calibrated lens.
        pose: Its pose; None until it is calibrated.
    """

    name: str
    source: str
    lens: Lens
    pose: CameraPose | None = None

    @cached_property
    def placed(self) -> CameraPose:
        """Its pose.

        Raises:
            SetcmasError: It is unknown.
        """
        if self.pose is None:
            raise SetcmasError(
                f"camera '{self.name}' has no pose: run setcmas camera with --calibrate floor"
            )
        return self.pose

    @cached_property
    def _turn(self) -> Floats:
        return np.asarray(cv2.Rodrigues(np.array(self.placed.rotation))[0], float)

    def pixels(self, points: Floats) -> Floats:
        """Return the pixels (N, 2) of points x, y, z in m, shape (N, 3)."""
        shift = -self._turn @ self.placed.position
        rotation, distortion = np.array(self.placed.rotation), np.array(self.lens.distortion)
        found, _ = cv2.projectPoints(points, rotation, shift, self.lens.matrix, distortion)
        return np.asarray(found, float).reshape(-1, 2)

    def points(self, pixels: Floats, height: float) -> Floats:
        """Return x and y in m (N, 2) where the rays of pixels (N, 2) meet the plane of a height.

        They are NaN where a ray does not meet the plane.
        """
        flat = np.asarray(pixels, float).reshape(-1, 1, 2)
        rays = cv2.undistortPoints(flat, self.lens.matrix, np.array(self.lens.distortion))
        directions = cv2.convertPointsToHomogeneous(rays).reshape(-1, 3) @ self._turn
        x, y, z = self.placed.position
        fall = np.where(directions[:, 2] < 0, directions[:, 2], np.nan)
        meets: Floats = (x, y) + ((height - z) / fall)[:, None] * directions[:, :2]
        return meets

    def sees(self, point: Floats) -> bool:
        """Return whether a point x, y, z in m is inside the picture."""
        if (self._turn @ (point - self.placed.position))[2] <= 0:
            return False
        pixel = self.pixels(point[None])[0]
        return bool((pixel >= 0).all() and (pixel <= np.array(self.lens.size) - 1).all())

    def accuracy(self, tags: RobotTags, x: float, y: float) -> Accuracy | None:
        """Return what to expect of a robot at x, y in m; None where the camera sees no tag.

        The pixels of a metre are those of the direction with the fewest.
        """
        point, half = np.array([x, y, tags.height]), tags.size / 2
        if not self.sees(point):
            return None
        ends = self.pixels(point + half * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]))
        jacobian = (ends[::2] - ends[1::2]) / tags.size
        per_metre = float(np.linalg.svd(jacobian, compute_uv=False)[-1])
        mean_of_corners = CORNER_ERROR_PX / 2  # four corners
        position = np.hypot(mean_of_corners, self.lens.error) / per_metre
        heading = CORNER_ERROR_PX / (np.sqrt(2.0) * per_metre * tags.size)
        position = np.hypot(position, self.placed.error)
        return Accuracy(float(position), float(heading), per_metre * tags.size)


@dataclass(frozen=True)
class CameraFile:
    """Content of a camera file.

    Attributes:
        tags: Tags on the robots; a robot's number is the number of its tag.
        cameras: The cameras.
        floor_tags: Centre x, y in m of each tag on the floor, by its number.
        floor_distances: Measured distances in m between the centres of two floor tags; empty if
            their positions are given.
    """

    tags: RobotTags
    cameras: tuple[Camera, ...] = ()
    floor_tags: dict[int, tuple[float, ...]] = field(default_factory=dict)
    floor_distances: dict[tuple[int, int], float] = field(default_factory=dict)


def load_cameras(path: Path, least: int = 1) -> CameraFile:
    """Return the content of a camera file with at least so many cameras.

    Raises:
        SetcmasError: The file has a mistake; the message names file and line.
    """
    content = read_entries(path)
    fields = _fields(content, CameraFile, ('tags',))
    sizes = _fields(fields['tags'], RobotTags)
    tags = RobotTags(_number(sizes['size'], 0.01, 2), _number(sizes['height'], 0, 2))
    cameras: dict[str, Camera] = {}
    for item in fields['cameras'].items() if 'cameras' in fields else ():
        camera = _camera(item, tags.height)
        if camera.name in cameras:
            raise item.error(f"two cameras have the name '{camera.name}'; each needs its own")
        cameras[camera.name] = camera
    if len(cameras) < least:
        raise content.error('there is no camera; begin with setcmas camera --calibrate lens')
    return CameraFile(
        tags,
        tuple(cameras.values()),
        _floor_tags(fields['floor_tags']) if 'floor_tags' in fields else {},
        _distances(fields['floor_distances']) if 'floor_distances' in fields else {},
    )


def write_cameras(content: CameraFile, path: Path) -> None:
    """Write a camera file, whole or not at all.

    Raises:
        SetcmasError: It cannot be written.
    """
    written = asdict(content)
    written['floor_distances'] = {
        f'{a}-{b}': distance for (a, b), distance in content.floor_distances.items()
    }
    for camera in written['cameras']:
        if camera['pose'] is None:
            del camera['pose']
    try:
        write_yaml(written, path)
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error


def _camera(entry: Entry, tag_height: float) -> Camera:
    fields = _fields(entry, Camera, ('name', 'source', 'lens'))
    name, source = fields['name'].text(), str(fields['source'].value)
    if not name:
        raise fields['name'].mistake('a name, such as left')
    pose = _pose(fields['pose'], tag_height) if 'pose' in fields else None
    return Camera(name, source, _lens(fields['lens']), pose)


def _lens(entry: Entry) -> Lens:
    fields = _fields(entry, Lens)
    width, height = _numbers(fields['size'], 2, 1, _MOST_PX)
    return Lens(
        (int(width), int(height)),
        _numbers(fields['focal'], 2, 1, _MOST_PX),
        _numbers(fields['centre'], 2),
        _numbers(fields['distortion'], 5),
        _number(fields['error'], 0, _MOST_PX),
    )


def _pose(entry: Entry, tag_height: float) -> CameraPose:
    fields = _fields(entry, CameraPose)
    position = _numbers(fields['position'], 3)
    if position[2] <= tag_height:
        must_be = f'x, y and z in m, with z above the {tag_height:g} m of the tags'
        raise fields['position'].mistake(must_be)
    return CameraPose(
        position, _numbers(fields['rotation'], 3), _number(fields['error'], 0, _MOST_M)
    )


def _floor_tags(entry: Entry) -> dict[int, tuple[float, ...]]:
    return {_tag(key, item): _numbers(item, 2) for key, item in _mapping(entry, '501: [0.0, 1.5]')}


def _distances(entry: Entry) -> dict[tuple[int, int], float]:
    found = {}
    for key, item in _mapping(entry, '501-502: 3.0'):
        first, dash, second = key.partition('-')
        if not dash or first == second:
            raise item.error(f"'{key}' is not a pair of tags, such as 501-502")
        found[_tag(first, item), _tag(second, item)] = _number(item, 0.01, _MOST_M)
    return found


def _mapping(entry: Entry, example: str) -> Iterable[tuple[str, Entry]]:
    if not isinstance(entry.value, dict):
        raise entry.mistake(f'a mapping such as {{{example}}}')
    return entry.value.items()


def _tag(text: str, entry: Entry) -> int:
    if not (text.isdecimal() and len(text) < 4 and int(text) <= _LAST_TAG):
        raise entry.error(f"'{text}' is not a tag; it must be a number from 0 to {_LAST_TAG}")
    return int(text)


def _numbers(
    entry: Entry, count: int, least: float = -math.inf, most: float = math.inf
) -> tuple[Any, ...]:
    if not isinstance(entry.value, list) or len(entry.value) != count:
        raise entry.mistake(f'a list of {count} numbers')
    return tuple(_number(item, least, most) for item in entry.value)


def _number(entry: Entry, least: float, most: float) -> float:
    number = entry.number()
    if not least <= number <= most:
        raise entry.mistake(f'from {least:g} to {most:g}')
    return number


def _fields(
    entry: Entry, shape: type[Any], needed: Iterable[str] | None = None
) -> dict[str, Entry]:
    """Return the entries of a mapping, which has the keys of a dataclass."""
    keys = [one.name for one in dataclasses.fields(shape)]
    fields = entry.fields(keys)
    if missing := [key for key in needed or keys if key not in fields]:
        raise entry.error(f'{entry.name or "this file"} has no {missing[0]}; add it')
    return fields
