"""Calls of scripts, and their failures."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from setcmas_simu.fleet.topics import robot_name


class Function(enum.Enum):
    """A function of a script."""

    CONTROL = 'control'
    CONDITION = 'ctc'
    SI_TO_UNI = 'si_to_uni'
    LOADING = 'loading'
    STEP = 'step'

    def late(self, script: str, seconds: float) -> str:
        """Return that a call of a script has lasted some time, as text."""
        if self is Function.LOADING:
            return f'{script} has been loading for {seconds:g} s'
        return f'{self.value} has not returned for {seconds:g} s'


@dataclass(frozen=True)
class ScriptCall:
    """A call of a function of a script, by its file name, for a robot."""

    robot: int
    script: str
    function: Function

    def __str__(self) -> str:
        """Return the call as text, such as `control of law.py for tb3_2`."""
        return f'{self.function.value} of {self.script} for {robot_name(self.robot)}'


@dataclass(frozen=True)
class ScriptFailure:
    """A period in which all calls of a script for a robot failed for the same reason.

    Attributes:
        t: Time of the first failed call in s, as control laws see it: a pause stops it.
        robot: Number of the robot.
        script: Name of the file with the error: the script, or a module that it imports.
        line: Line of the error in that file, if known.
        text: The message shown to the user.
        until: End of the period in s, also when the reason changed; None for the end of the run.
    """

    t: float
    robot: int
    function: Function
    script: str
    line: int | None
    text: str
    until: float | None = None

    @property
    def first_line(self) -> str:
        """The message in a line, without its place."""
        text, place = self.text.partition('\n')[0], f'{self.script}, line {self.line}'
        for before in (f'{place}: ', f'{self.script}: '):
            text = text.removeprefix(before)
        return text.removesuffix(f' at {place}')
