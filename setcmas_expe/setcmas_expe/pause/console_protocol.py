"""Messages between the terminal and the pause process of an experiment."""

from __future__ import annotations

import enum

import msgspec

from setcmas_expe.safety.safety_decision import State
from setcmas_expe.safety.stalls import time_since_boot
from setcmas_simu.reports.reports import Message

SILENT_AFTER_S = 0.5
"""Silence in s from which the terminal counts as stuck, which pauses."""

OLD_AFTER_S = 1.0
"""Age in s from which a press starts nothing: it was held up between the processes."""

UNKNOWN = 0.0
"""Time of a press that may be an old one: that of the boot."""


class Word(enum.Enum):
    """What the terminal, or the page that it has opened, has to say."""

    PAUSE = 'pause'

    START = 'start'
    """Start, by a key or a button; repeated while that is held."""

    GO = 'go'
    """Start, by a command that does so once everything is ready."""

    EMERGENCY = 'emergency'
    """Emergency stop."""

    RELEASE = 'release'
    """The first or the second press that releases it."""

    HALT = 'halt'
    """The bridge process has died: command zero in its place."""

    END = 'end'
    """The experiment ends: pause, and do not wonder about what ends too."""

    ALIVE = 'alive'
    """Somebody still serves the keyboard; sent several times a second."""


class Wish(Message, frozen=True):
    """A message of the terminal.

    Attributes:
        by: How it was made, such as 'by space bar'.
        made: When, in s since boot, on the clock of this machine.
    """

    word: Word
    by: str = ''
    made: float = msgspec.field(default_factory=time_since_boot)


class RobotStatus(msgspec.Struct, frozen=True):
    """What a line of the terminal tells of a robot; texts as in /diagnostics.

    Attributes:
        runs_away: Whether it moves although it is commanded zero.
        ready: Whether nothing but the pause keeps it from moving, or it moves.
    """

    name: str
    level: int
    state: State
    reason: str
    pose_age: str
    battery: str
    speed: str
    runs_away: bool
    ready: bool


class Status(Message, frozen=True):
    """What the terminal shows: the pause state, and a line for each robot."""

    paused: bool
    emergency: bool
    why: str
    robots: tuple[RobotStatus, ...]
