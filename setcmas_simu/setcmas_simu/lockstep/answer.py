"""Answers of the followers of a simulation in lockstep, as sent on /lockstep."""

from __future__ import annotations

import os
import socket

import msgspec

NONE = -1
"""Stands for no time."""


class Follower(msgspec.Struct, frozen=True):
    """A process that follows: a controller of robots, or a recorder, which has none."""

    host: str
    process: int
    robots: tuple[int, ...] = ()

    def __str__(self) -> str:
        """Return the process in words."""
        kind = 'controller' if self.robots else 'recorder'
        return f'{kind} (process {self.process} on {self.host})'


class Answer(msgspec.Struct, frozen=True):
    """What a process has done.

    Attributes:
        follower: The process.
        stamp: The time of the states that it is done with, in ns.
        commanded: The stamp of the commands that it has sent last, in ns; NONE if there are none.
        leaves: Whether nothing more is to be expected of it.
    """

    follower: Follower
    stamp: int
    commanded: int = NONE
    leaves: bool = False


def this_process(robots: tuple[int, ...] = ()) -> Follower:
    """Return this process as one that follows."""
    return Follower(socket.gethostname(), os.getpid(), robots)


def encode(answer: Answer) -> str:
    """Return the text of an answer."""
    return msgspec.json.encode(answer).decode()


def decode(text: str) -> Answer | None:
    """Return the answer that a text is; None if it is none."""
    try:
        return msgspec.json.decode(text, type=Answer)
    except msgspec.DecodeError:
        return None
