"""Start poses: `--poses FILE.yaml`, `--pose 3:1.0,2.0,1.57` and `--random-poses`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import check_in_fleet
from setcmas_simu.yaml_entries import Entry, read_entries

Pose = tuple[float, float, float]
GivenPoses = Path | Mapping[int, Pose] | Sequence[Pose]
_FORM = 'x, y in m and theta in rad, such as [1.0, 2.0, 1.57]; theta is optional'


def parse_pose_option(text: str) -> tuple[int, Pose]:
    """Return the robot and its pose in a text such as '3:1.0,2.0,1.57', or raise SetcmasError."""
    number, colon, values = text.partition(':')
    if not colon or not number.strip().isdecimal() or int(number) < 1:
        raise SetcmasError(f"pose '{text}' must be ROBOT:x,y,theta, such as '3:1.0,2.0,1.57'")
    return int(number), _pose(values.split(','), f"pose '{text}'")


def poses_of_entry(content: Entry, nb_robots: int = 1) -> dict[int, Pose]:
    """Return the start poses by robot in an entry of a YAML file, or raise SetcmasError.

    The entry is a list with a pose for each robot from 1, at least nb_robots, or a mapping from
    robots (`3` or `tb3_3`) to poses. A pose is a list of x, y (m) and theta (rad).
    """
    if isinstance(content.value, list):
        if content.value:
            with content.located():
                _check_number(len(content.value), nb_robots)
        poses = dict(enumerate(content.value, start=1))
    elif isinstance(content.value, dict):
        poses = _by_number(content.value)
    else:
        poses = {}
    if not poses:
        raise content.mistake('a list of poses or a mapping from robots to poses')
    return {robot: _pose_of_entry(entry) for robot, entry in poses.items()}


def _check_number(poses: int, nb_robots: int) -> None:
    if poses < nb_robots:
        raise SetcmasError(
            f'{poses} poses for {nb_robots} robots; add poses, or place only some robots with a '
            "mapping such as '3: [1, 2, 0]'"
        )


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


def poses_of_array(poses: ArrayLike, nb_robots: int) -> tuple[Pose, ...]:
    """Return the poses in x, y (m) and theta (rad), (3, nb_robots), or raise SetcmasError."""
    array = np.array(poses, dtype=float)
    if array.shape != (3, nb_robots) or not np.isfinite(array).all():
        raise SetcmasError(
            f'poses have shape {array.shape}; they must be finite numbers of shape '
            f'(3, {nb_robots})'
        )
    return tuple((x, y, theta) for x, y, theta in array.T.tolist())


def given_poses(
    nb_robots: int, poses: GivenPoses | None = None, pose_options: Iterable[str] = ()
) -> dict[int, Pose]:
    """Return start poses by robot: those of all (in order, by robot or in a file) and single ones.

    Single poses, as for `parse_pose_option`, replace others.

    Raises:
        SetcmasError: A pose is malformed, or its robot is not in the fleet.
    """
    given = _by_robot(poses, nb_robots) if poses is not None else {}
    # A file may serve fleets of several sizes; a single pose for a missing robot is a mistake.
    given = {robot: pose for robot, pose in given.items() if robot <= nb_robots}
    named: set[int] = set()
    for text in pose_options:
        robot, pose = parse_pose_option(text)
        check_in_fleet([robot], nb_robots, f"pose '{text}'")
        if robot in named:
            raise SetcmasError(f"pose '{text}': robot {robot} already has a pose; remove one")
        named.add(robot)
        given[robot] = pose
    return given


def _by_robot(poses: GivenPoses, nb_robots: int) -> dict[int, Pose]:
    if isinstance(poses, Path):
        return poses_of_entry(read_entries(poses), nb_robots)
    if isinstance(poses, Mapping):
        check_in_fleet(poses, nb_robots, 'poses')
        return dict(poses)
    _check_number(len(poses), nb_robots)
    return dict(enumerate(poses, start=1))


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


AUTO = 'auto'
"""Text for a box and a distance that suit the fleet."""

FORM = f"{AUTO}, or box=WIDTHxHEIGHT and distance=D in m, such as 'box=4x3,distance=0.5'"
"""Accepted texts for random start poses."""

_SIDE = 10.0  # m, as the square of the default start poses
_DISTANCE = 1.0  # m
_SPACE = 4.0  # box area per robot in squared distances: a third of the densest packing
_TRIES = 10_000  # for each robot: misses only gaps smaller than 0.1 % of the box

_NUMBER = r'0*[1-9]\d*(?:\.\d*)?|\d*\.\d*[1-9]\d*'
_TEXT = re.compile(
    rf'(?!,)(?:box=(?P<width>{_NUMBER})x(?P<height>{_NUMBER}))?(?:(?:^|,)distance=(?P<d>{_NUMBER}))?'
)


@dataclass(frozen=True)
class RandomPoses:
    """Rule for random start poses.

    Attributes:
        size: Width and height of the box in m; None is a square of 10 m, larger for many robots.
        distance: Minimum distance between robots in m; None is 1 m, less in a full box.
        centre: Centre of the box, x and y in m.
    """

    size: tuple[float, float] | None = None
    distance: float | None = None
    centre: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, text: str) -> RandomPoses:
        """Read a text such as 'auto' or 'box=4x3,distance=0.5', or raise SetcmasError."""
        found = _TEXT.fullmatch(text) if text else None
        if text != AUTO and not found:
            raise SetcmasError(f'invalid random poses {text!r}; must be {FORM}')
        box = found and found['width']
        size = (float(found['width']), float(found['height'])) if found and box else None
        return cls(size, float(found['d']) if found and found['d'] else None)

    def within(
        self, centre: tuple[float, float], size: tuple[float, float], most: tuple[float, float]
    ) -> RandomPoses:
        """Return the same rule inside a room; `size` replaces a box that was not given.

        `centre` and `most` are centre, width and height of the room in m. Raises SetcmasError if
        the given box is larger than the room.
        """
        chosen = self.size or size
        if chosen[0] > most[0] or chosen[1] > most[1]:
            raise SetcmasError(
                f'the box of random poses is {_shown(chosen)} m; it must fit into the arena, '
                f'{_shown(most)} m'
            )
        return replace(self, size=chosen, centre=centre)

    def draw(self, nb_robots: int, seed: int, given: Mapping[int, Pose] | None = None) -> Floats:
        """Draw start poses, robot by robot, until each is far enough from the earlier ones.

        Dart throwing (Cook, ACM Transactions on Graphics 5(1), 1986). Headings are uniform in
        (-pi, pi]. The seed alone decides the poses; robots keep their distance from given ones.

        Returns:
            Rows x, y in m and theta in rad, shape (3, nb_robots).

        Raises:
            SetcmasError: The robots do not fit into the box.
        """
        side = max(_SIDE, math.sqrt(_SPACE * nb_robots) * _DISTANCE)
        size = np.array(self.size or (side, side))
        roomy = math.sqrt(size.prod() / (_SPACE * nb_robots))
        distance = min(_DISTANCE, roomy) if self.distance is None else self.distance
        generator = np.random.default_rng(seed)
        placed = np.full((nb_robots, 3), np.nan)
        for robot, pose in (given or {}).items():
            placed[robot - 1] = pose
        for row in np.flatnonzero(np.isnan(placed[:, 0])).tolist():
            for _ in range(_TRIES):
                place = self.centre + size * (generator.random(2) - 0.5)
                # Comparisons with NaN are false: robots without a pose yet are ignored.
                if not (np.hypot(*(placed[:, :2] - place).T) < distance).any():
                    break
            else:
                raise SetcmasError(
                    f'{nb_robots} robots do not fit into a box of '
                    f'{_shown(size)} m at least {distance:g} m apart; use a larger box or '
                    f'distance={_floored(roomy)}'
                )
            placed[row] = *place, math.pi * (1.0 - 2.0 * generator.random())
        poses: Floats = placed.T.copy()
        return poses


def _shown(size: tuple[float, float] | Floats) -> str:
    return f'{size[0]:g}x{size[1]:g}'


def _floored(distance: float) -> str:
    """Return a distance in m as text, rounded down to two digits."""
    digits = 1 - math.floor(math.log10(distance))
    return f'{math.floor(distance * 10**digits) / 10**digits:g}'
