"""Find the robots by cameras above them and printed tags, in place of motion capture.

Print tags with `setcmas tags`. Calibrate each lens with the board. Write the places of four or
more floor tags into the camera file; calibrate the floor.
Then the command publishes the poses of the robots until Ctrl-C; experiments take them with
`--mocap camera`.

Examples:
  setcmas camera camera.yaml --calibrate lens --source 0 --name left
  setcmas camera camera.yaml --calibrate floor
  setcmas camera camera.yaml
"""

from __future__ import annotations

import argparse
from pathlib import Path

from launch_scripts.environment import lab_environment, require_ros
from launch_scripts.processes import CAMERA, add_ros_arguments
from launch_scripts.supervisor import run_node
from setcmas_simu.errors import SetcmasError

_TAG_SIZE, _TAG_HEIGHT = 0.12, 0.2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument('file', type=Path, metavar='FILE', help='camera file, such as camera.yaml')
    calibrate = 'calibrate a lens with the board, or the poses of all cameras with the floor tags'
    parser.add_argument('--calibrate', choices=['lens', 'floor'], help=calibrate)
    name = 'name of the camera whose lens is calibrated (default: camera)'
    parser.add_argument('--name', default='camera', metavar='NAME', help=name)
    source = 'where its pictures come from: number of a camera, a video file, or a series '
    source += 'such as pictures/%%03d.png (default: 0)'
    parser.add_argument('--source', default='0', metavar='SOURCE', help=source)
    add_ros_arguments(parser)


def main(args: argparse.Namespace) -> int:
    """Calibrate, or publish poses; return the exit status."""
    from setcmas_expe.mocap.camera_file import load_cameras

    if args.calibrate == 'lens':
        _calibrate_lens(args.file, args.name, args.source)
    elif args.calibrate == 'floor':
        _calibrate_floor(args.file)
    else:
        require_ros()
        load_cameras(args.file)  # report mistakes before anything starts
        # Poses must reach the experiment, which may run on another machine.
        environment = lab_environment(())
        return run_node(args, CAMERA, [str(args.file)], environment=environment, may_end=True)
    return 0


def _calibrate_lens(path: Path, name: str, source: str) -> None:
    from msgspec.structs import replace

    from setcmas_expe.mocap import camera_calibration, camera_file, picture_sources

    file = camera_file.CameraFile(camera_file.RobotTags(_TAG_SIZE, _TAG_HEIGHT))
    if path.exists():
        file = camera_file.load_cameras(path, least=0)
    elif not path.parent.is_dir():
        raise SetcmasError(f"'{path}' cannot be written: there is no folder '{path.parent}'")
    print('hold the board still, flat, in many places of the picture; Ctrl-C ends', flush=True)
    shots = picture_sources.pictures(source, None)
    lens = camera_calibration.calibrated_lens(shots, lambda line: print(line, flush=True))
    others = tuple(camera for camera in file.cameras if camera.name != name)
    camera = camera_file.Camera(name, source, lens)
    camera_file.write_cameras(replace(file, cameras=(*others, camera)), path)
    print(f'{path}: lens of {name} with an error of {lens.error:.2f} px; next: --calibrate floor')


def _calibrate_floor(path: Path) -> None:
    from setcmas_expe.mocap.camera_calibration import calibrated_floor
    from setcmas_expe.mocap.camera_file import load_cameras, write_cameras

    file = calibrated_floor(load_cameras(path))
    write_cameras(file, path)
    for camera in file.cameras:
        x, y, z = (round(value, 2) + 0.0 for value in camera.placed.position)  # never -0.00
        print(
            f'{camera.name}: at x = {x:.2f} m, y = {y:.2f} m, {z:.2f} m above the floor; '
            f'floor tags fit within {1e3 * camera.placed.error:.1f} mm'
        )
