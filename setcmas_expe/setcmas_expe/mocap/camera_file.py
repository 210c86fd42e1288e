"""Cameras over the floor: lens, pose and projection of each, and the file that holds them."""

from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta, Struct

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, file_errors, needs
from setcmas_simu.yaml_entries import Entry, read_entries, write_yaml

with needs('camera'):
    import cv2

FIRST_FLOOR_TAG = 501
"""Number of the first tag on the floor; robots have the numbers below it."""

LAST_TAG = 586
"""Number of the last tag of the family 36h11; the first is 0."""

Tag = Annotated[int, Meta(ge=0, le=LAST_TAG)]
_Number = Annotated[float, Meta(ge=-1e6, le=1e6)]
_Metres = Annotated[float, Meta(ge=0, le=100)]
_Pixels = Annotated[float, Meta(ge=0, le=20_000)]
_Side = Annotated[int, Meta(ge=1, le=20_000)]
Place = tuple[_Number, _Number]
"""Centre x, y of a tag on the floor, in m."""


class RobotTags(Struct, frozen=True, forbid_unknown_fields=True):
    """Tags on the robots: side of the black square and height above the floor in m."""

    size: Annotated[float, Meta(ge=0.01, le=2)]
    height: Annotated[float, Meta(ge=0, le=2)]


class Lens(Struct, frozen=True, forbid_unknown_fields=True):
    """Pinhole camera with radial and tangential distortion.

    Attributes:
        size: Width and height of the picture in px.
        focal: Focal lengths in px.
        centre: Principal point in px; the centre of the first pixel is (0, 0).
        distortion: k1, k2, p1, p2, k3, as in OpenCV.
        error: Root mean square error of the calibration in px.
    """

    size: tuple[_Side, _Side]
    focal: tuple[_Pixels, _Pixels]
    centre: tuple[_Number, _Number]
    distortion: tuple[_Number, _Number, _Number, _Number, _Number]
    error: _Pixels

    @property
    def matrix(self) -> Floats:
        """The camera matrix, shape (3, 3)."""
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


class CameraPose(Struct, frozen=True, forbid_unknown_fields=True):
    """Pose of a camera over the floor.

    Attributes:
        position: x, y and z in m; the floor has z = 0.
        rotation: Rotation vector in rad from the floor's axes to the camera's (x to the right of
            the picture, y down, z forward).
        error: Standard deviation of positions on the floor that the calibration leaves, in m.
    """

    position: tuple[_Number, _Number, _Number]
    rotation: tuple[_Number, _Number, _Number]
    error: _Metres


class Camera(Struct, frozen=True, forbid_unknown_fields=True, dict=True):
    """A camera, which maps pixels to points above the floor.

    Attributes:
        name: Its name.
        source: Where its pictures come from: number or path of a device, a video file, or a series
            of pictures such as 'pictures/%03d.png'.
        lens: Its calibrated lens.
        pose: Its pose; None until it is calibrated.
    """

    name: Annotated[str, Meta(min_length=1)]
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


class CameraFile(Struct, frozen=True, forbid_unknown_fields=True):
    """Content of a camera file.

    Attributes:
        tags: Tags on the robots; a robot's number is the number of its tag.
        cameras: The cameras.
        floor_tags: Place of each tag on the floor, by its number.
    """

    tags: RobotTags
    cameras: tuple[Camera, ...] = ()
    floor_tags: dict[Tag, Place] = {}


def load_cameras(path: Path, least: int = 1) -> CameraFile:
    """Return the content of a camera file with at least so many cameras.

    Raises:
        SetcmasError: The file has a mistake; the message names file and line.
    """
    entry = read_entries(path)
    try:
        content = msgspec.convert(entry.plain(), CameraFile, str_keys=True)
    except msgspec.ValidationError as error:
        what, _, place = str(error).partition(' - at ')
        wrong = _entry_at(entry, place)
        raise wrong.error(f'{wrong.name or "this file"}: {what[:1].lower()}{what[1:]}') from None
    for number, camera in enumerate(content.cameras):
        item = entry.value['cameras'].items()[number]
        if camera.name in [other.name for other in content.cameras[:number]]:
            raise item.error(f"two cameras have the name '{camera.name}'; each needs its own")
        if camera.pose and camera.pose.position[2] <= content.tags.height:
            raise item.value['pose'].error(
                f'the camera is {camera.pose.position[2]:g} m above the floor, but the tags are '
                f'{content.tags.height:g} m above it'
            )
    if len(content.cameras) < least:
        raise entry.error('there is no camera; begin with setcmas camera --calibrate lens')
    return content


def _entry_at(entry: Entry, place: str) -> Entry:
    """Return the entry at a place in the words of msgspec, such as `$.cameras[0].lens`."""
    for name, index in re.findall(r'\.(\w+)|\[(\d+)\]', place):
        entry = entry.value[name] if name else entry.value[int(index)]
    return entry


def write_cameras(content: CameraFile, path: Path) -> None:
    """Write a camera file, whole or not at all, or raise SetcmasError."""
    with file_errors(f"'{path}' cannot be written"):
        write_yaml(msgspec.to_builtins(content), path)
