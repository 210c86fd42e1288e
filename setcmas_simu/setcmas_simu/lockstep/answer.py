"""Answers of followers to a simulation in lockstep, sent on /lockstep."""

from __future__ import annotations

import os
import socket

import msgspec

NONE = -1
"""No time."""


class Follower(msgspec.Struct, frozen=True):
    """A process that follows simulated time: a controller of robots, or a recorder (no robots)."""

    host: str
    process: int
    robots: tuple[int, ...] = ()

    def __str__(self) -> str:
        """Return the process as text."""
        kind = 'controller' if self.robots else 'recorder'
        return f'{kind} (process {self.process} on {self.host})'


class Answer(msgspec.Struct, frozen=True):
    """Progress of a follower.

    Attributes:
        follower: The process.
        stamp: Stamp in ns of the newest states that it has finished with.
        commanded: Stamp in ns of the last commands that it sent; NONE if it sent none.
        leaves: Whether it stops following.
    """

    follower: Follower
    stamp: int
    commanded: int = NONE
    leaves: bool = False


def this_process(robots: tuple[int, ...] = ()) -> Follower:
    """Return this process as a follower."""
    return Follower(socket.gethostname(), os.getpid(), robots)


def encode(answer: Answer) -> str:
    """Return an answer as text."""
    return msgspec.json.encode(answer).decode()


def decode(text: str) -> Answer | None:
    """Return the answer in a text; None if there is none."""
    try:
        return msgspec.json.decode(text, type=Answer)
    except msgspec.DecodeError:
        return None
