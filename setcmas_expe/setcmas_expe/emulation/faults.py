"""Faults of an emulated lab, and the text message that injects one."""

from __future__ import annotations

import math
import re
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
DEAF = 'deaf'
PERSON = 'person'

PURPOSES = {
    DROPOUT: 'motion capture sends nothing for the robot',
    ZERO: 'motion capture sends position 0, quaternion 0',
    NAN: 'motion capture sends values that are not numbers',
    FROZEN: 'motion capture repeats the last pose',
    JUMP: 'motion capture sees the robot 1 m away from its place',
    SWAP: 'motion capture swaps the names of this robot and the next',
    LATE: 'its poses arrive 1 s late',
    DRIFT: 'its poses drift away at 0.3 m/s',
    GLIDE: 'its poses glide away at 2 m/s',
    FALLEN: 'its marker body has fallen off',
    MIRRORED: 'the y axis of its poses points the other way',
    TURNED: 'its body is turned by 90 degrees',
    SLOW: 'motion capture sees it twice a second',
    LIFT: 'the robot is lifted by 15 cm; its wheels turn in the air',
    BLOCKED: 'the robot is held while its wheels turn',
    STALLED: 'its wheels do not turn',
    OFF: 'the robot is switched off, then switched on again',
    UNGUARDED: 'its guard hangs',
    DEAF: 'its base takes no commands, and keeps the last one',
    PUSH: 'the robot is pushed out of the arena',
    PERSON: 'a person steps in front of it; its lidar sees that if the lab has a lidar stop',
}
"""What happens in each fault, by name."""

OF_MOCAP = PURPOSES.keys() - {PUSH, BLOCKED, STALLED, OFF, UNGUARDED, DEAF, PERSON}
"""Faults of motion capture; the others are of the robot itself."""

DEFAULT_S = 3.0
"""Default duration of a fault in s."""

_ROBOT = re.compile(r'0*[1-9][0-9]*')
_FORM = f"it must be 'KIND ROBOT [SECONDS]' with one of {', '.join(PURPOSES)}"


@dataclass(frozen=True)
class Fault:
    """A fault (one of PURPOSES) of a robot, or of its poses, for a duration in s."""

    kind: str
    robot: int
    duration: float = DEFAULT_S

    def __str__(self) -> str:
        """Return the text that `parse_fault` reads."""
        return f'{self.kind} {self.robot} {self.duration:g}'


def parse_fault(text: str) -> Fault:
    """Return the fault in a text such as 'dropout 2 3.0', or raise SetcmasError."""
    words = text.split()
    if not 2 <= len(words) <= 3 or words[0] not in PURPOSES or not _ROBOT.fullmatch(words[1]):
        raise SetcmasError(f"fault '{text}' is not understood; {_FORM}")
    return Fault(words[0], int(words[1]), _seconds(words[2], text) if words[2:] else DEFAULT_S)


def _seconds(text: str, fault: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise SetcmasError(f"fault '{fault}' lasts '{text}'; it must be a time in s above 0")
    return seconds
