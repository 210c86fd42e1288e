"""Camera file: lens and pose of each camera, robot tags and floor tags, with their uncertainty."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, field
from pathlib import Path

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.options.kinds import Number, Whole
from setcmas_simu.yaml_entries import Entry, read_entries, write_yaml

LAST_TAG = 586
"""Largest number of a tag in the family 36h11; its first is 0."""

_KEYS = ('tags', 'floor_tags', 'floor_distances', 'cameras')
_TAGS = ('size', 'height')
_CAMERA = ('name', 'source', 'lens', 'pose')
_LENS = ('size', 'focal', 'centre', 'distortion', 'error')
_POSE = ('position', 'rotation', 'error')
_MOST_PIXELS = 20_000


@dataclass(frozen=True)
class RobotTags:
    """Tags on the robots.

    Attributes:
        size: Side of the black square in m.
        height: Height of the tag above the floor in m.
    """

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
class Camera:
    """A camera.

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


def load_cameras(path: Path) -> CameraFile:
    """Return the content of a camera file.

    Raises:
        SetcmasError: The file has a mistake; the message names file and line.
    """
    fields = _all_fields(read_entries(path), _KEYS, ('tags', 'cameras'))
    sizes = _all_fields(fields['tags'], _TAGS)
    size = _POSITIVE.of(sizes['size'])
    tags = RobotTags(float(size), float(Number(least=0, most=2, unit='m').of(sizes['height'])))
    cameras: dict[str, Camera] = {}
    for item in fields['cameras'].items():
        camera = _camera(item, tags.height)
        if camera.name in cameras:
            raise item.error(f"two cameras have the name '{camera.name}'; each needs its own")
        cameras[camera.name] = camera
    places, distances = fields.get('floor_tags'), fields.get('floor_distances')
    return CameraFile(
        tags,
        tuple(cameras.values()),
        _floor_tags(places) if places else {},
        _distances(distances) if distances else {},
    )


def write_cameras(content: CameraFile, path: Path) -> None:
    """Write a camera file, whole or not at all, or raise OSError."""
    write_yaml(
        {
            'tags': dict(zip(_TAGS, astuple(content.tags), strict=True)),
            'floor_tags': {str(tag): list(xy) for tag, xy in content.floor_tags.items()},
            'floor_distances': {
                f'{a}-{b}': length for (a, b), length in content.floor_distances.items()
            },
            'cameras': [_written(camera) for camera in content.cameras],
        },
        path,
    )


_POSITIVE = Number(above=0, most=2, unit='m')
_ERROR = Number(least=0, finite=True)


def _camera(entry: Entry, tag_height: float) -> Camera:
    fields = _all_fields(entry, _CAMERA, _CAMERA[:3])
    name, source = fields['name'].text(), str(fields['source'].value)
    if not name:
        raise fields['name'].mistake('a name, such as left')
    pose = _pose(fields['pose'], tag_height) if 'pose' in fields else None
    return Camera(name, source, _lens(fields['lens']), pose)


def _lens(entry: Entry) -> Lens:
    fields = _all_fields(entry, _LENS)
    size = _numbers(fields['size'], 2, Whole(1, _MOST_PIXELS))
    focal = _numbers(fields['focal'], 2, Number(above=0, finite=True))
    centre = _numbers(fields['centre'], 2, Number(finite=True))
    distortion = _numbers(fields['distortion'], 5, Number(finite=True))
    return Lens(
        (int(size[0]), int(size[1])),
        (focal[0], focal[1]),
        (centre[0], centre[1]),
        distortion,
        float(_ERROR.of(fields['error'])),
    )


def _pose(entry: Entry, tag_height: float) -> CameraPose:
    fields = _all_fields(entry, _POSE)
    position = _numbers(fields['position'], 3, Number(finite=True))
    if position[2] <= tag_height:
        raise fields['position'].mistake(
            f'x, y and z in m, with z above the {tag_height:g} m of the tags'
        )
    rotation = _numbers(fields['rotation'], 3, Number(finite=True))
    return CameraPose(position, rotation, float(_ERROR.of(fields['error'])))


def _floor_tags(entry: Entry) -> dict[int, tuple[float, ...]]:
    numbers = {str(number): number for number in range(LAST_TAG + 1)}
    if not isinstance(entry.value, dict):
        raise entry.mistake('a mapping from tag to its centre, such as {501: [0.0, 1.5]}')
    for key, item in entry.value.items():
        if key not in numbers:
            raise item.error(f"'{key}' is not a tag; it must be a number from 0 to {LAST_TAG}")
    anywhere = Number(finite=True)
    return {numbers[key]: _numbers(item, 2, anywhere) for key, item in entry.value.items()}


def _distances(entry: Entry) -> dict[tuple[int, int], float]:
    form = 'a mapping from two tags to their distance in m, such as {501-502: 3.0}'
    if not isinstance(entry.value, dict):
        raise entry.mistake(form)
    found = {}
    for key, item in entry.value.items():
        a, _, b = str(key).partition('-')
        if not (a.isdecimal() and b.isdecimal() and a != b):
            raise entry.mistake(form)
        found[int(a), int(b)] = float(Number(above=0, finite=True, unit='m').of(item))
    return found


def _numbers(entry: Entry, count: int, kind: Number | Whole) -> tuple[float, ...]:
    if not isinstance(entry.value, list) or len(entry.value) != count:
        raise entry.mistake(f'a list of {count} numbers')
    return tuple(float(kind.of(item)) for item in entry.value)


def _all_fields(
    entry: Entry, keys: Iterable[str], needed: Iterable[str] | None = None
) -> dict[str, Entry]:
    fields = entry.fields(keys)
    missing = [key for key in needed or keys if key not in fields]
    if missing:
        raise entry.error(f'{entry.name or "this file"} has no {missing[0]}; add it')
    return fields


def _written(camera: Camera) -> dict[str, object]:
    lens, pose = camera.lens, camera.pose
    written: dict[str, object] = {
        'name': camera.name,
        'source': camera.source,
        'lens': {
            'size': list(lens.size),
            'focal': list(lens.focal),
            'centre': list(lens.centre),
            'distortion': list(lens.distortion),
            'error': lens.error,
        },
    }
    if pose:
        written['pose'] = {
            'position': list(pose.position),
            'rotation': list(pose.rotation),
            'error': pose.error,
        }
    return written
