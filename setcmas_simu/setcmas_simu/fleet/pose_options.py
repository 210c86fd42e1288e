"""Start poses from options: `--poses FILE.yaml` and `--pose 3:1.0,2.0,1.57`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_simu.yaml_entries import Entry, read_entries

Pose = tuple[float, float, float]
_FORM = 'x, y in m and theta in rad, such as [1.0, 2.0, 1.57]; theta is optional'


def parse_pose_option(text: str) -> tuple[int, Pose]:
    """Return the robot and its pose in a text such as '3:1.0,2.0,1.57'.

    Raises:
        SetcmasError: The text has another form, or a value is not finite.
    """
    number, colon, values = text.partition(':')
    if not colon or not number.strip().isdecimal() or int(number) < 1:
        raise SetcmasError(f"--pose '{text}' must be ROBOT:x,y,theta, such as '3:1.0,2.0,1.57'")
    return int(number), _pose(values.split(','), f"--pose '{text}'")


def load_poses(path: Path, nb_robots: int = 1) -> dict[int, Pose]:
    """Read start poses by robot from a YAML file.

    The file is a list with a pose for each robot from 1, or a mapping from robots (`3` or
    `tb3_3`) to poses. A pose is a list of x, y (m) and theta (rad).

    Args:
        path: The file.
        nb_robots: Size of the fleet: a list must have a pose for each robot.

    Raises:
        SetcmasError: The file cannot be read, has another form, or has too few poses.
    """
    return poses_of_entry(read_entries(path), nb_robots)


def poses_of_entry(content: Entry, nb_robots: int = 1) -> dict[int, Pose]:
    """Return the start poses by robot in an entry of a YAML file; forms as in `load_poses`.

    Raises:
        SetcmasError: The entry has another form, or too few poses.
    """
    if isinstance(content.value, list):
        if 0 < len(content.value) < nb_robots:
            raise content.error(
                f'{len(content.value)} poses for {nb_robots} robots; add poses, or '
                'place only some robots with a mapping such as '
                "'3: [1, 2, 0]'"
            )
        poses = dict(enumerate(content.value, start=1))
    elif isinstance(content.value, dict):
        poses = _by_number(content.value)
    else:
        poses = {}
    if not poses:
        raise content.mistake('a list of poses or a mapping from robots to poses')
    return {robot: _pose_of_entry(entry) for robot, entry in poses.items()}


def _by_number(entries: dict[str, Entry]) -> dict[int, Entry]:
    poses: dict[int, Entry] = {}
    for key, entry in entries.items():
        number = key.removeprefix('tb3_')
        if not number.isdecimal() or int(number) < 1:
            raise entry.error(f"robot '{key}' must be a number from 1, or tb3_1, tb3_2, ...")
        if int(number) in poses:
            raise entry.error(f'robot {int(number)} has two poses; remove one')
        poses[int(number)] = entry
    return poses


def _pose_of_entry(entry: Entry) -> Pose:
    items = entry.value if isinstance(entry.value, list) else []
    if len(items) not in (2, 3):
        raise entry.mistake(_FORM)
    x, y, theta = (*(item.number() for item in items), 0.0)[:3]
    return (x, y, theta)


def given_poses(
    nb_robots: int, poses_file: Path | None = None, pose_options: Iterable[str] = ()
) -> dict[int, Pose]:
    """Return start poses by robot: those of the file, replaced by single ones.

    Args:
        nb_robots: Size of the fleet.
        poses_file: A YAML file as `load_poses` reads it.
        pose_options: Texts as `parse_pose_option` reads them.

    Raises:
        SetcmasError: A pose is malformed, or its robot is not in the fleet.
    """
    given = load_poses(poses_file, nb_robots) if poses_file else {}
    # A file may serve fleets of several sizes; a single pose for a missing robot is a mistake.
    given = {robot: pose for robot, pose in given.items() if robot <= nb_robots}
    named: set[int] = set()
    for text in pose_options:
        robot, pose = parse_pose_option(text)
        if robot > nb_robots:
            raise SetcmasError(
                f"--pose '{text}' is for robot {robot}; the fleet has robots 1 to {nb_robots}"
            )
        if robot in named:
            raise SetcmasError(f"--pose '{text}': robot {robot} already has a pose; remove one")
        named.add(robot)
        given[robot] = pose
    return given


def _pose(values: list[str], where: str) -> Pose:
    try:
        numbers = [float(value) for value in values]
    except ValueError:
        numbers = []
    if len(numbers) == 2:
        numbers.append(0.0)
    if len(numbers) != 3 or not all(math.isfinite(number) for number in numbers):
        raise SetcmasError(f'{where}: {values!r} must be {_FORM}')
    return (numbers[0], numbers[1], numbers[2])
