"""Announcement of robots: who has them, their models, and their simulated time."""

from __future__ import annotations

import enum
import os
import socket

import msgspec


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

    robot_rate: float
    nb_steps: int | None = None


class Scaled(msgspec.Struct, frozen=True, tag=True):
    """Simulated time at `rtf` s per real second; it begins at `begin` (s) of the system clock."""

    rtf: float
    begin: float


SimulatedTime = Lockstep | Scaled


class Announcement(msgspec.Struct, frozen=True):
    """The robots (sorted numbers) of one process, all of a fleet or a part.

    Models are names or scripts, empty if all are unicycles; a time of None is the system clock.
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
    """Return the announcement in a text; None if it is malformed."""
    try:
        return msgspec.json.decode(text, type=Announcement)
    except msgspec.DecodeError:
        return None
