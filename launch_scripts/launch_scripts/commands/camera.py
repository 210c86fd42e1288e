"""Find the robots by cameras above them and printed tags, in place of motion capture.

Print tags with `setcmas tags`. Calibrate each lens with the board. Write the places of four or
more floor tags into the camera file, or their distances to the first two; calibrate the floor.
Then the command publishes the poses of the robots until Ctrl-C; experiments take them with
`--mocap camera`.

Examples:
  setcmas camera camera.yaml --calibrate lens --source 0 --name left
  setcmas camera camera.yaml --calibrate floor
  setcmas camera camera.yaml
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from launch_scripts.processes.environment import require_ros
from launch_scripts.processes.foreground import run_in_foreground
from launch_scripts.processes.node_commands import (
    CAMERA,
    add_ros_arguments,
    node_command,
    ros_arguments,
)
from setcmas_simu.errors import SetcmasError

if TYPE_CHECKING:
    from setcmas_expe.camera.picture_sources import PictureSource
    from setcmas_expe.camera.tag_detection import Shot

_NB_PICTURES = 30
_TAG_SIZE, _TAG_HEIGHT = 0.12, 0.2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('file', type=Path, metavar='FILE', help='camera file, such as camera.yaml')
    calibrate = 'calibrate a lens with the board, or the poses of all cameras with the floor tags'
    parser.add_argument('--calibrate', choices=['lens', 'floor'], help=calibrate)
    name = 'name of the camera whose lens is calibrated (default: camera)'
    parser.add_argument('--name', default='camera', metavar='NAME', help=name)
    source = (
        'where its pictures come from: number of a camera, video file, folder, or topic of ROS '
        '(default: 0)'
    )
    parser.add_argument('--source', default='0', metavar='SOURCE', help=source)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Calibrate, or publish poses; return the exit status."""
    from setcmas_expe.camera.camera_file import load_cameras

    if args.calibrate == 'lens':
        _calibrate_lens(args.file, args.name, args.source)
    elif args.calibrate == 'floor':
        _calibrate_floor(args.file)
    else:
        require_ros()
        load_cameras(args.file)  # report mistakes before anything starts
        return run_in_foreground(
            'camera', node_command(CAMERA, [str(args.file), *ros_arguments(args)])
        )
    return 0


def _calibrate_lens(path: Path, name: str, source: str) -> None:
    from setcmas_expe.camera.calibration import LensViews
    from setcmas_expe.camera.camera_file import (
        Camera,
        CameraFile,
        RobotTags,
        load_cameras,
        write_cameras,
    )
    from setcmas_expe.camera.picture_sources import open_source

    empty = CameraFile(RobotTags(_TAG_SIZE, _TAG_HEIGHT))
    file = load_cameras(path) if path.exists() else empty
    views = LensViews()
    print('hold the board still, flat, in many places of the picture; Ctrl-C ends', flush=True)
    for _, picture in _shots(open_source(source, None)):
        if views.add(picture):
            print(f'view {len(views)}; next: {"; ".join(views.missing()) or "done"}', flush=True)
            if not views.missing():
                break
    lens = views.lens()
    others = tuple(camera for camera in file.cameras if camera.name != name)
    write_cameras(replace(file, cameras=(*others, Camera(name, source, lens))), path)
    print(f'{path}: lens of {name} with an error of {lens.error:.2f} px; next: --calibrate floor')


def _calibrate_floor(path: Path) -> None:
    import numpy as np

    from setcmas_expe.camera.calibration import floor_pose, places_from_distances
    from setcmas_expe.camera.camera_file import load_cameras, write_cameras
    from setcmas_expe.camera.picture_sources import open_source
    from setcmas_expe.camera.tag_detection import TagDetector

    file = load_cameras(path)
    if not file.cameras:
        raise SetcmasError(f"'{path}' has no camera; begin with --calibrate lens")
    places = file.floor_tags
    if file.floor_distances:
        places = places_from_distances(file.floor_distances)
    if len(places) < 4:
        raise SetcmasError(
            f"'{path}' has {len(places)} floor tags; write the centres of four or more, such as "
            'floor_tags: {501: [0.0, 0.0]}, or floor_distances: {501-502: 3.0}'
        )
    cameras = []
    for camera in file.cameras:
        seen = defaultdict(list)
        shots = _shots(open_source(camera.source, camera.lens.size))
        for _, (_, picture) in zip(range(_NB_PICTURES), shots, strict=False):
            for tag, corners in TagDetector().corners(picture)[0].items():
                seen[tag].append(corners)
        middle = {tag: np.median(corners, axis=0) for tag, corners in seen.items()}
        pose = floor_pose(camera, places, middle)
        x, y, z = (round(value, 2) + 0.0 for value in pose.position)  # never -0.00
        print(
            f'{camera.name}: at x = {x:.2f} m, y = {y:.2f} m, {z:.2f} m above the floor, '
            f'by {len(places.keys() & seen.keys())} tags, within {1e3 * pose.error:.1f} mm'
        )
        cameras.append(replace(camera, pose=pose))
    write_cameras(replace(file, cameras=tuple(cameras), floor_tags=places), path)


def _shots(source: PictureSource) -> Iterator[Shot]:
    while shot := source.read():
        yield shot
