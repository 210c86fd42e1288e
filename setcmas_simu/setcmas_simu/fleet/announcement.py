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
    """Return the announcement in a text; None if it is malformed."""
    try:
        return msgspec.json.decode(text, type=Announcement)
    except msgspec.DecodeError:
        return None
