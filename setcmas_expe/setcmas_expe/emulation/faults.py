"""Faults of an emulated lab, and the line of text that orders one."""

from __future__ import annotations

import math
from dataclasses import dataclass

from setcmas_simu.errors import SetcmasError

DROPOUT = 'dropout'
ZERO = 'zero'
NAN = 'nan'
FROZEN = 'frozen'
JUMP = 'jump'
SWAP = 'swap'
LATE = 'late'
PUSH = 'push'
DRIFT = 'drift'
GLIDE = 'glide'
LIFT = 'lift'
FALLEN = 'fallen'
MIRRORED = 'mirrored'
TURNED = 'turned'
SLOW = 'slow'
BLOCKED = 'blocked'
STALLED = 'stalled'
OFF = 'off'
UNGUARDED = 'unguarded'

PURPOSES = {
    DROPOUT: 'motion capture sends nothing for the robot',
    ZERO: 'it sends position 0, quaternion 0',
    NAN: 'it sends values that are not numbers',
    FROZEN: 'it repeats the last pose',
    JUMP: 'it sees the robot 1 m beside its place',
    SWAP: 'it takes the robot for the next one, and the next one for the robot',
    LATE: 'its poses arrive 1 s late',
    DRIFT: 'its poses drift away at 0.3 m/s',
    GLIDE: 'its poses glide away at 2 m/s',
    FALLEN: 'its marker body has fallen off, and lies there',
    MIRRORED: 'the y axis of its poses points the other way',
    TURNED: 'its body is turned by 90 degrees',
    SLOW: 'it is seen twice a second',
    LIFT: 'somebody lifts the robot by 15 cm; its wheels turn in the air',
    BLOCKED: 'something holds the robot while its wheels turn',
    STALLED: 'its wheels stand, whatever they are commanded',
    OFF: 'the robot is switched off, and then on again',
    UNGUARDED: 'its guard hangs',
    PUSH: 'somebody pushes the robot out of the arena, away from the centre',
}
"""Every fault by name, and what happens then."""

OF_MOCAP = PURPOSES.keys() - {PUSH, BLOCKED, STALLED, OFF, UNGUARDED}
"""Those that motion capture shows; the others befall the robot itself."""

DEFAULT_S = 3.0
"""How long a fault lasts unless told, in s."""

_FORM = f"it must be 'KIND ROBOT [SECONDS]' with one of {', '.join(PURPOSES)}"


@dataclass(frozen=True)
class Fault:
    """A fault of one robot, or of what the motion capture system tells of it.

    Attributes:
        kind: One of PURPOSES.
        robot: Number of the robot.
        duration: How long it lasts, in s.
    """

    kind: str
    robot: int
    duration: float = DEFAULT_S

    def __str__(self) -> str:
        """Return the text that `parse_fault` understands."""
        return f'{self.kind} {self.robot} {self.duration:g}'


def parse_fault(text: str) -> Fault:
    """Return the fault that a text such as 'dropout 2 3.0' orders.

    Raises:
        SetcmasError: The text has another form.
    """
    words = text.split()
    if not 2 <= len(words) <= 3 or words[0] not in PURPOSES or not _is_robot(words[1]):
        raise SetcmasError(f"fault '{text}' is not understood; {_FORM}")
    return Fault(words[0], int(words[1]), _seconds(words[2], text) if words[2:] else DEFAULT_S)


def _is_robot(text: str) -> bool:
    return text.isdecimal() and int(text) >= 1


def _seconds(text: str, fault: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise SetcmasError(f"fault '{fault}' lasts '{text}'; it must be a time in s above 0")
    return seconds
