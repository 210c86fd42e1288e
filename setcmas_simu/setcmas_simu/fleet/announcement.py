"""Announcement of robots on /fleet: the line of each process that has some."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from setcmas_simu.fleet.topics import MAX_ROBOTS

_Robot = Annotated[int, Meta(ge=1, le=MAX_ROBOTS)]


class Announcement(msgspec.Struct, frozen=True, omit_defaults=True):
    """The robots of one process, all of a fleet or a part.

    Their simulated time goes by at `rtf` s per real second.
    """

    nb_robots: Annotated[_Robot, Meta(description='size of the whole fleet')]
    robots: Annotated[tuple[_Robot, ...], Meta(description='sorted numbers')]
    models: Annotated[
        tuple[str, ...], Meta(description='name or script for each robot; empty for unicycles')
    ] = ()
    limits: Annotated[str, Meta(description='velocity limits of unicycles')] = 'ideal'
    rtf: Annotated[float, Meta(gt=0, description='real-time factor')] = 1.0
    begin: Annotated[
        float, Meta(description='time 0 in s of the system clock, if rtf is not 1')
    ] = 0.0


def encode(announcement: Announcement) -> str:
    """Return an announcement as a line of JSON."""
    return msgspec.json.encode(announcement).decode()


def decode(line: str) -> Announcement:
    """Return the announcement in a line; raise ValueError if it does not fit the schema."""
    return msgspec.json.decode(line, type=Announcement)
