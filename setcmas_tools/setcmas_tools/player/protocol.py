"""Messages between the terminal and the player."""

from __future__ import annotations

import enum

from setcmas_simu.reports.encoding import Message


class Key(enum.Enum):
    """What is asked of the player."""

    TOGGLE = 'toggle'
    FORTH = 'forth'
    BACK = 'back'


class Pressed(Message, frozen=True):
    """A key was pressed in the terminal."""

    key: Key


class Playing(Message, frozen=True):
    """Where the player is.

    Attributes:
        at: Time in s from the first message of the bag.
        duration: Time in s of the last one.
    """

    at: float
    duration: float
    paused: bool
