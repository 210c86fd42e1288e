"""Fleet tb3_1 .. tb3_N: numbers, colours and start poses of its robots, and /fleet."""

from __future__ import annotations

import enum
import math
import os
import re
import socket
from collections.abc import Iterable

import msgspec
import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError

Colour = tuple[float, float, float]

_START_POSES_OF_8 = (
    (5.0, 5.0),
    (5.0, -5.0),
    (-5.0, -5.0),
    (-5.0, 5.0),
    (0.0, 5.0),
    (5.0, 0.0),
    (0.0, -5.0),
    (-5.0, 0.0),
)
_FIRST_RING_RADIUS = 8.5  # m: more than 1 m outside the corners of the square of the first 8
_RING_SPACING = 1.25  # m, between rings and at least between neighbours on a ring

_COLOURS: tuple[Colour, ...] = (
    (1.0, 0.0, 0.0),  # red
    (0.0, 1.0, 0.0),  # green
    (0.0, 0.0, 1.0),  # blue
    (1.0, 0.91, 0.31),  # yellow
    (1.0, 1.0, 1.0),  # white
    (0.96, 0.18, 0.92),  # magenta
    (1.0, 0.49, 0.37),  # salmon
    (0.0, 0.0, 0.0),  # black
)
_GREY: Colour = (0.5, 0.5, 0.5)
_BRIGHT = 0.7
_LIGHT_GREY: Colour = (0.78, 0.78, 0.78)
_WHITE_ROBOT = 5


def start_poses(nb_robots: int) -> Floats:
    """Return the default start poses of a fleet.

    One robot starts at the origin, several on the border of a 10 m square as in ROS 1, further
    ones on rings around it that keep 1 m between robots.

    Args:
        nb_robots: Number of robots in the fleet, at least 1.

    Returns:
        Rows x, y in m and theta in rad (all 0), shape (3, nb_robots).
    """
    poses = np.zeros((3, nb_robots))
    if nb_robots == 1:
        return poses
    places = list(_START_POSES_OF_8)
    radius = _FIRST_RING_RADIUS
    while len(places) < nb_robots:
        # The chord between neighbours is a little shorter than the arc, hence the spacing > 1 m.
        nb_on_ring = int(2 * math.pi * radius / _RING_SPACING)
        angles = 2 * math.pi * np.arange(nb_on_ring) / nb_on_ring
        places.extend(zip(radius * np.cos(angles), radius * np.sin(angles), strict=True))
        radius += _RING_SPACING
    poses[:2] = np.array(places[:nb_robots]).T
    return poses


def colour(robot: int) -> Colour:
    """Return the colour of a robot as (red, green, blue), each in [0, 1], from its number."""
    return _COLOURS[robot - 1] if robot <= len(_COLOURS) else _GREY


def plot_colour(robot: int) -> Colour:
    """Return the colour of a robot on white paper: as `colour`, but the white robot light grey."""
    return _LIGHT_GREY if robot == _WHITE_ROBOT else colour(robot)


def is_bright(colour: Colour) -> bool:
    """Return whether a colour needs a dark edge on white paper, by its luminance."""
    red, green, blue = colour
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue >= _BRIGHT


def plot_hex(robot: int) -> str:
    """Return the colour of a robot on white paper as hexadecimal text, such as '#ff0000'."""
    return '#' + ''.join(f'{round(255 * part):02x}' for part in plot_colour(robot))


def parse_robots(text: str) -> list[int]:
    """Return the sorted robot numbers in a text such as '1-4' or '2,5-7'.

    Raises:
        SetcmasError: The text has another form, or a number below 1.
    """
    robots: set[int] = set()
    for part in text.split(','):
        found = re.fullmatch(r'\s*([1-9][0-9]{0,3})\s*(?:-\s*([1-9][0-9]{0,3}))?\s*', part)
        if not found or int(found[2] or found[1]) < int(found[1]):
            raise SetcmasError(
                f"invalid robots '{text}'; must be numbers from 1 and ranges, "
                "such as '1-4' or '2,5-7'"
            )
        robots.update(range(int(found[1]), int(found[2] or found[1]) + 1))
    return sorted(robots)


def robots_in_words(robots: list[int], verb: str = '') -> str:
    """Return 'robot 2' or 'robots 1-3' for sorted numbers, and a verb: 'are' or 'have'."""
    if len(robots) == 1:
        verb = {'are': 'is', 'have': 'has'}.get(verb, verb)
    plural = 's' if len(robots) != 1 else ''
    return f'robot{plural} {format_robots(robots)} {verb}'.rstrip()


def format_robots(robots: list[int]) -> str:
    """Return the shortest text that `parse_robots` turns into these sorted robot numbers."""
    runs: list[list[int]] = []
    for robot in robots:
        if runs and robot == runs[-1][-1] + 1:
            runs[-1].append(robot)
        else:
            runs.append([robot])
    return ','.join(f'{run[0]}-{run[-1]}' if len(run) > 1 else f'{run[0]}' for run in runs)


class Kind(enum.Enum):
    """The kind of process that has the robots."""

    SIMULATOR = 'simulator'
    LAB = 'lab'


class Source(msgspec.Struct, frozen=True):
    """The process that has the robots."""

    kind: Kind
    host: str
    process: int

    def __str__(self) -> str:
        """Return the source as text."""
        return f'{self.kind.value} (process {self.process} on {self.host})'


class Lockstep(msgspec.Struct, frozen=True, tag=True):
    """Simulated time from 0 that advances once every follower has answered.

    Attributes:
        robot_rate: Rate of the robots' states in Hz.
        nb_steps: Number of steps after which time stops; None is never.
    """

    robot_rate: float
    nb_steps: int | None = None


class Scaled(msgspec.Struct, frozen=True, tag=True):
    """Simulated time from 0 that runs faster or slower than the system clock.

    Attributes:
        rtf: Real time factor: simulated seconds per real second.
        begin: The system clock at simulated time 0, in s.
    """

    rtf: float
    begin: float


SimulatedTime = Lockstep | Scaled


class Announcement(msgspec.Struct, frozen=True):
    """The robots of one process.

    Attributes:
        nb_robots: Size of the fleet; these robots may be a part of it.
        robots: Numbers of the robots, sorted.
        source: The process.
        models: Name of each robot's model or of its script; empty if all are unicycles.
        time: Their simulated time; None is the system clock.
    """

    nb_robots: int
    robots: tuple[int, ...]
    source: Source
    models: tuple[str, ...] = ()
    time: SimulatedTime | None = None


def own_source(kind: Kind, process: int | None = None) -> Source:
    """Return a process of this machine as a source; by default this process."""
    return Source(kind, socket.gethostname(), os.getpid() if process is None else process)


def encode(announcement: Announcement) -> str:
    """Return an announcement as text."""
    return msgspec.json.encode(announcement).decode()


def decode(text: str) -> Announcement | None:
    """Return the announcement in a text; None if there is none."""
    try:
        return msgspec.json.decode(text, type=Announcement)
    except msgspec.DecodeError:
        return None


def models_of(announcements: Iterable[Announcement]) -> dict[int, str]:
    """Return the announced models by robot."""
    return {
        robot: model
        for announcement in announcements
        for robot, model in zip(announcement.robots, announcement.models, strict=False)
    }


def robots_of(announcements: Iterable[Announcement]) -> list[int]:
    """Return the numbers of all announced robots, sorted."""
    return sorted({robot for announcement in announcements for robot in announcement.robots})
