"""Announcement of robots on /fleet: who has them, their models, and their simulated time."""

from __future__ import annotations

import enum
import os
import socket
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from setcmas_simu.fleet.topics import MAX_ROBOTS


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
        return f'{self.kind.value} (process {self.process} on {self.host})'


class Lockstep(msgspec.Struct, frozen=True, tag=True):
    """Simulated time that advances once every follower has answered, for nb_steps if given."""

    robot_rate: Annotated[float, Meta(gt=0, description='steps per simulated second')]
    nb_steps: Annotated[int, Meta(ge=0)] | None = None


class Scaled(msgspec.Struct, frozen=True, tag=True):
    """Simulated time at `rtf` s per real second; it begins at `begin` (s) of the system clock."""

    rtf: Annotated[float, Meta(gt=0)]
    begin: float


SimulatedTime = Lockstep | Scaled


_Robot = Annotated[int, Meta(ge=1, le=MAX_ROBOTS)]


class Announcement(msgspec.Struct, frozen=True):
    """The robots (sorted numbers) of one process, all of a fleet or a part.

    Models are names or scripts, empty if all are unicycles; without time, the system clock counts.
    """

    nb_robots: Annotated[_Robot, Meta(description='size of the whole fleet')]
    robots: Annotated[tuple[_Robot, ...], Meta(description='sorted numbers')]
    source: Source
    models: Annotated[tuple[str, ...], Meta(description='one per robot')] = ()
    time: SimulatedTime | None = None
    version: Literal[1] = 1


def own_source(kind: Kind, process: int | None = None) -> Source:
    """Return a process of this machine as a source; by default this process."""
    return Source(kind, socket.gethostname(), os.getpid() if process is None else process)


def encode(announcement: Announcement) -> str:
    """Return an announcement as text."""
    return msgspec.json.encode(announcement).decode()


def decode(text: str) -> Announcement:
    """Return the announcement in a text; raise ValueError if it does not fit the schema."""
    return msgspec.json.decode(text, type=Announcement)
