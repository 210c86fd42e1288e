"""What the terminal and the pause process tell each other, a line each, over pipes."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

TOGGLE = 'toggle'
"""The space bar: start if paused, else pause."""

PAUSE = 'pause'
"""A space bar that is heard of late: whatever was meant by it, not a start now."""

GO = 'go'
"""Start."""

HALT = 'halt'
"""The bridge process has died: command zero in its place."""

END = 'end'
"""The experiment ends: pause, and do not wonder about what ends too."""

ALIVE = 'alive'
"""Somebody still serves the keyboard; sent several times a second."""

SILENT_AFTER_S = 0.5
"""Silence in s from which the terminal counts as stuck, which pauses."""

_MARK = '\x02status '


@dataclass(frozen=True)
class RobotStatus:
    """What a line of the terminal tells of a robot; texts as in /diagnostics.

    Attributes:
        ready: Whether nothing but the pause keeps it from moving, or it moves.
    """

    name: str
    level: int
    state: str
    reason: str
    pose_age: str
    battery: str
    speed: str
    ready: bool


@dataclass(frozen=True)
class Status:
    """What the terminal shows: the pause state, and a line for each robot."""

    paused: bool
    why: str
    robots: tuple[RobotStatus, ...]

    def encode(self) -> str:
        """Return the line that `decode` understands."""
        return _MARK + json.dumps(asdict(self))


def decode(line: str) -> Status | None:
    """Return the status in a line of output; None if the line is meant for people."""
    _, mark, text = line.partition(_MARK)
    if not mark:
        return None
    fields = json.loads(text)
    robots = tuple(RobotStatus(**robot) for robot in fields['robots'])
    return Status(fields['paused'], fields['why'], robots)
