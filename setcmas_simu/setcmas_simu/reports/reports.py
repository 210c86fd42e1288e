"""Kinds of reports: what a node process tells the launcher."""

from __future__ import annotations

import enum

import msgspec

from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.encoding import Message


class Function(enum.Enum):
    """What of a script is called."""

    CONTROL = 'control'
    CONDITION = 'ctc'
    LOADING = 'loading'
    STEP = 'step'


class ScriptCall(msgspec.Struct, frozen=True):
    """A call of a script for a robot.

    Attributes:
        robot: Number of the robot.
        script: File name of the script.
        function: What is called.
    """

    robot: int
    script: str
    function: Function

    def __str__(self) -> str:
        """Return the call in words, such as `control of law.py for tb3_2`."""
        return f'{self.function.value} of {self.script} for {robot_name(self.robot)}'


class ScriptFailure(msgspec.Struct, frozen=True, omit_defaults=True):
    """A time in which the calls of a script for a robot failed, each for the same reason.

    Attributes:
        t: When the first one failed, in s: the t of the control laws, which a pause stops.
        robot: Number of the robot.
        function: What was called.
        script: Name of the file that failed: the script, or a module that it imports.
        line: The line there, if there is one.
        text: What the user was told.
        until: When it was over, or the reason was another one, in s; None for the end of the run.
    """

    t: float
    robot: int
    function: Function
    script: str
    line: int | None
    text: str
    until: float | None = None


class Ready(Message, frozen=True):
    """The process does its work, and ends in its own order when it is asked to."""


class Mistake(Message, frozen=True):
    """The process ends with status 2: the user gave something that cannot be, and was told."""

    text: str


class Started(Message, frozen=True):
    """Control laws are called from now on."""

    robots: tuple[int, ...]
    law: str


class Failed(Message, frozen=True):
    """A call has failed for the first time with this text; the robot stands meanwhile."""

    call: ScriptCall
    text: str


class Stuck(Message, frozen=True):
    """A call does not return; `where` is file and line."""

    call: ScriptCall
    where: str


class Ended(Message, frozen=True):
    """The controllers end in order.

    Attributes:
        failed: Calls that failed, or hung, at some time.
        failures: When which calls failed, of scripts as they were loaded first.
    """

    failed: tuple[ScriptCall, ...]
    failures: tuple[ScriptFailure, ...] = ()


WRITES_S = 60.0
"""Time in s that a recorder gets to end: a busy machine writes the index of a large bag slowly."""


class Recording(Message, frozen=True):
    """The recorder has found the topics that are there."""

    nb_topics: int


class Paused(Message, frozen=True):
    """The robots of a simulation are paused by a wish, or go on."""

    paused: bool


class Reached(Message, frozen=True):
    """A simulation in lockstep has reached a time.

    Attributes:
        t: The time in s.
    """

    t: float


class Reloaded(Message, frozen=True):
    """The control scripts were saved and are loaded again.

    Attributes:
        works: Whether they could be loaded.
    """

    works: bool


Report = (
    Ready | Mistake | Started | Failed | Stuck | Ended | Recording | Paused | Reached | Reloaded
)
