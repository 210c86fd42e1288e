"""Cameras over the floor: lens, pose and projection of each, and the file that holds them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, file_errors, needs
from setcmas_simu.yaml_entries import Entry, read_entries, write_yaml

with needs('camera'):
    import cv2

Shape = TypeVar('Shape')

FIRST_FLOOR_TAG = 501
"""Number of the first tag on the floor; robots have the numbers below it."""

_LAST_TAG = 586  # of the family 36h11; the first is 0
_MOST_PX, _MOST_M = 20_000, 100


def _numbers(count: int, least: float = -math.inf, most: float = math.inf) -> Any:
    """Return a field of a list of numbers within bounds; 0 is a single number."""
    return field(metadata={'numbers': (count, least, most)})


@dataclass(frozen=True)
class RobotTags:
    """Tags on the robots: side of the black square and height above the floor in m."""

    size: float = _numbers(0, 0.01, 2)
    height: float = _numbers(0, 0, 2)


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

    size: tuple[int, int] = _numbers(2, 1, _MOST_PX)
    focal: tuple[float, float] = _numbers(2, 1, _MOST_PX)
    centre: tuple[float, float] = _numbers(2)
    distortion: tuple[float, ...] = _numbers(5)
    error: float = _numbers(0, 0, _MOST_PX)

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

    position: tuple[float, ...] = _numbers(3)
    rotation: tuple[float, ...] = _numbers(3)
    error: float = _numbers(0, 0, _MOST_M)


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
        """Its pose; SetcmasError if it is unknown."""
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
        return (x, y) + ((height - z) / fall)[:, None] * directions[:, :2]

    def sees(self, point: Floats) -> bool:
        """Return whether a point x, y, z in m is inside the picture."""
        if (self._turn @ (point - self.placed.position))[2] <= 0:
            return False
        pixel = self.pixels(point[None])[0]
        return bool((pixel >= 0).all() and (pixel <= np.array(self.lens.size) - 1).all())


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
    found = _fields(content, CameraFile, 'tags')
    tags = _read(found['tags'], RobotTags)
    cameras: dict[str, Camera] = {}
    for item in found['cameras'].items() if 'cameras' in found else ():
        camera = _camera(item, tags.height)
        if camera.name in cameras:
            raise item.error(f"two cameras have the name '{camera.name}'; each needs its own")
        cameras[camera.name] = camera
    if len(cameras) < least:
        raise content.error('there is no camera; begin with setcmas camera --calibrate lens')
    places = {
        _tag(key, item): _checked(item, 2) for key, item in _mapping(found.get('floor_tags'))
    }
    distances = dict(_distance(*one) for one in _mapping(found.get('floor_distances')))
    return CameraFile(tags, tuple(cameras.values()), places, distances)


def write_cameras(content: CameraFile, path: Path) -> None:
    """Write a camera file, whole or not at all, or raise SetcmasError."""
    written = asdict(content)
    distances = content.floor_distances.items()
    written['floor_distances'] = {f'{a}-{b}': distance for (a, b), distance in distances}
    with file_errors(f"'{path}' cannot be written"):
        write_yaml(written, path)


def _camera(entry: Entry, tag_height: float) -> Camera:
    found = _fields(entry, Camera, 'name', 'source', 'lens')
    name, source = found['name'].text(), str(found['source'].value)
    if not name:
        raise found['name'].mistake('a name, such as left')
    lens, pose = _read(found['lens'], Lens), None
    if 'pose' in found and found['pose'].value is not None:
        pose = _read(found['pose'], CameraPose)
        if pose.position[2] <= tag_height:
            raise found['pose'].error(
                f'the camera is {pose.position[2]:g} m above the floor, but the tags are '
                f'{tag_height:g} m above it'
            )
    return Camera(name, source, lens, pose)


def _distance(key: str, entry: Entry) -> tuple[tuple[int, int], float]:
    first, dash, second = key.partition('-')
    if not dash or first == second:
        raise entry.error(f"'{key}' is not a pair of tags, such as 501-502")
    return (_tag(first, entry), _tag(second, entry)), _checked(entry, 0, 0.01, _MOST_M)


def _tag(text: str, entry: Entry) -> int:
    if not (text.isdecimal() and len(text) < 4 and int(text) <= _LAST_TAG):
        raise entry.error(f"'{text}' is not a tag; it must be a number from 0 to {_LAST_TAG}")
    return int(text)


def _mapping(entry: Entry | None) -> Iterable[tuple[str, Entry]]:
    if entry and not isinstance(entry.value, dict):
        raise entry.mistake('a mapping, such as {501: [0.0, 1.5]} or {501-502: 3.0}')
    return entry.value.items() if entry else ()


def _read(entry: Entry, shape: type[Shape]) -> Shape:
    """Return a dataclass of numbers."""
    forms = {one.name: one.metadata['numbers'] for one in fields(shape)}  # type: ignore[arg-type]
    found = _fields(entry, shape, *forms)
    return shape(**{name: _checked(found[name], *form) for name, form in forms.items()})


def _checked(entry: Entry, count: int, least: float = -math.inf, most: float = math.inf) -> Any:
    """Return a list of numbers, or one number if the count is 0."""
    if count and (not isinstance(entry.value, list) or len(entry.value) != count):
        raise entry.mistake(f'a list of {count} numbers')
    if count:
        return tuple(_checked(item, 0, least, most) for item in entry.value)
    if not least <= entry.number() <= most:
        raise entry.mistake(f'from {least:g} to {most:g}')
    return entry.plain()


def _fields(entry: Entry, shape: type, *needed: str) -> dict[str, Entry]:
    """Return the entries of a mapping, which has the keys of a dataclass."""
    found = entry.fields(one.name for one in fields(shape))
    if missing := [key for key in needed if key not in found]:
        raise entry.error(f'{entry.name or "this file"} has no {missing[0]}; add it')
    return found
