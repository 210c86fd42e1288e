"""Announcement of a fleet: which robots a simulator or a lab has, as it tells on /fleet."""

from __future__ import annotations

import enum
import os
import socket
from collections.abc import Iterable

import msgspec


class Kind(enum.Enum):
    """What has the robots."""

    SIMULATOR = 'simulator'
    LAB = 'lab'


class Source(msgspec.Struct, frozen=True):
    """The process that has the robots."""

    kind: Kind
    host: str
    process: int

    def __str__(self) -> str:
        """Return the source in words."""
        return f'{self.kind.value} (process {self.process} on {self.host})'


class Lockstep(msgspec.Struct, frozen=True, tag=True):
    """Time that goes on when all that follow have answered, from 0 on.

    Attributes:
        robot_rate: Rate of the robots' states in Hz.
        nb_steps: After how many steps it stands still; None is never.
    """

    robot_rate: float
    nb_steps: int | None = None


class Scaled(msgspec.Struct, frozen=True, tag=True):
    """Time that goes faster or slower than the system's, from 0 on.

    Attributes:
        rtf: Real time factor: how many seconds of it pass in a second.
        begin: The time of the system's clock at its 0, in s.
    """

    rtf: float
    begin: float


SimulatedTime = Lockstep | Scaled


class Announcement(msgspec.Struct, frozen=True):
    """The robots of one process.

    Attributes:
        nb_robots: Size of the fleet, of which this may be a part.
        robots: Numbers of the robots, sorted.
        source: The process.
        models: The name of each one's model, or of its script; none where all are unicycles.
        time: The time that they follow; None is the system's.
    """

    nb_robots: int
    robots: tuple[int, ...]
    source: Source
    models: tuple[str, ...] = ()
    time: SimulatedTime | None = None


def own_source(kind: Kind, process: int | None = None) -> Source:
    """Return the source that a process of this machine is; by default this process."""
    return Source(kind, socket.gethostname(), os.getpid() if process is None else process)


def encode(announcement: Announcement) -> str:
    """Return the text of an announcement."""
    return msgspec.json.encode(announcement).decode()


def decode(text: str) -> Announcement | None:
    """Return the announcement that a text is; None if it is none."""
    try:
        return msgspec.json.decode(text, type=Announcement)
    except msgspec.DecodeError:
        return None


def models_of(announcements: Iterable[Announcement]) -> dict[int, str]:
    """Return the models of the robots whose model is announced."""
    return {
        robot: model
        for one in announcements
        for robot, model in zip(one.robots, one.models, strict=False)
    }


def robots_of(announcements: Iterable[Announcement]) -> list[int]:
    """Return the numbers of all announced robots, sorted."""
    return sorted({robot for one in announcements for robot in one.robots})
