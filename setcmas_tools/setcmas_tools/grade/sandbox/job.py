"""Job of a process that holds a submission, and the messages that go to and fro for it."""

from __future__ import annotations

import struct
from typing import Any

import msgspec

MOST_ASKED = 1 << 16
"""Size of the longest job, in bytes."""
MOST_ANSWERED = 1 << 13
"""Size of the longest message that a submission may send, in bytes."""

PLACE, EXIT = b'?', b'x'
"""What else is asked of the process that holds submissions: to let this one tell where it is, and
to end it."""
READY = b'r'
"""What that process says when it can hold a submission."""
NUMBER = struct.Struct('<i')
"""Process number of a submission that is held, and its exit status once it is ended."""

CALL = struct.Struct('<HHxxxxd')
"""Number of a robot, whether a new adjacency matrix follows its poses, and time in s.

Behind it are the numbers of the arrays that the function takes.
"""
LOADED = {False: b'loaded', True: b'loaded, with velocities'}
"""What a submission says once it is loaded, by whether its condition takes velocities."""
VELOCITY = struct.Struct('<dd')
"""What a law answers; any answer of another size is a `Refusal`."""
TRIGGERED = struct.Struct('<?')
"""What a condition answers."""


class Job(msgspec.Struct, frozen=True):
    """What a process is to hold.

    Attributes:
        script: Name of the script, in the folder that is its home.
        is_condition: Whether it is a triggering condition; else it is a control law.
        nb_robots: Size of the fleet.
        seed: That of the random numbers.
        settings: Values for names of the script.
        seconds: Processor time that it may take, in s.
    """

    script: str
    is_condition: bool
    nb_robots: int
    seed: int
    settings: dict[str, Any]
    seconds: int


class Refusal(msgspec.Struct, frozen=True):
    """Why there is no answer.

    Attributes:
        message: What went wrong, as setcmas tells it.
        kind: What a student would call it.
        file: Name of the file where it did.
        line: The line there; 0 if it is not known.
    """

    message: str
    kind: str = ''
    file: str = ''
    line: int = 0
