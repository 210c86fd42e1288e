"""Marks of a submission: what each criterion wanted, what was reached, and the points for it.

All are frozen and made of plain values, so that msgspec writes and reads them (`msgspec.json`).
Equal submissions get equal marks: nothing here depends on the clock, the machine or the folder.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol

from setcmas_tools.grade.rubric_scenarios import MarkedScenario
from setcmas_tools.run.run import Run

_AROUND = 2  # lines before and after the one that failed
_LONGEST_LINE = 200  # characters of each
_NEWLINE = re.compile(r'\r\n|\r|\n')  # Python's; str.splitlines knows others
_LARGE = 1000  # from here on a figure is told without decimals
_DIGITS = 4  # of points: sums of shares are not to differ in their last bits


@dataclass(frozen=True)
class Student:
    """Whose a submission is, as far as file names tell.

    Attributes:
        name: Such as 'Ada Lovelace'; may hold anything, so pages must escape it.
        id: Number or login on the learning platform; empty if unknown.
        email: Empty if unknown.
    """

    name: str
    id: str = ''
    email: str = ''


@dataclass(frozen=True)
class Failure:
    """What went wrong with a script.

    Attributes:
        message: What, as setcmas tells it; may have several lines and hold anything.
        script: Name of the file, without its folder; empty if no line is known.
        line: Line of the student's own code, from 1; 0 if it is not known.
        first: Number of the first of `around`.
        around: The lines around that one.
        robot: For which robot, from 1; 0 if it is none in particular.
        t: When, in s of the run; None if it did not start.
    """

    message: str
    script: str = ''
    line: int = 0
    first: int = 0
    around: tuple[str, ...] = ()
    robot: int = 0
    t: float | None = None

    def at(self, script: str, line: int, source: str) -> Failure:
        """Return the same in a line of a script, of which the text is known."""
        first = max(1, line - _AROUND)
        lines = _NEWLINE.split(source.rstrip('\r\n'))[first - 1 : line + _AROUND]
        around = tuple(one[:_LONGEST_LINE] for one in lines)
        return replace(self, script=script, line=line, first=first, around=around)


@dataclass(frozen=True)
class CriterionMark:
    """The mark of one criterion.

    Attributes:
        name: What was wanted, in words.
        points: What was reached, from 0 to `max_points`.
        max_points: For all of it.
        metric: What was measured, such as 'disagreement'.
        wanted: Its bounds in words, such as 'at most 0.05 m'.
        reached: Its value; None if there is none.
        unit: Its unit; empty if it has none.
        hint: What to tell the student; empty if all points were reached, or the script failed.
        hidden: Whether students see nothing of it but its points.
        missing: Why there is no value; empty if there is one, or nobody knows.
    """

    name: str
    points: float
    max_points: float
    metric: str
    wanted: str
    reached: float | None
    unit: str = ''
    hint: str = ''
    hidden: bool = False
    missing: str = ''

    @property
    def is_full(self) -> bool:
        """Whether all points were reached: a tick, else a cross."""
        return self.points == self.max_points

    @property
    def reached_text(self) -> str:
        """The value with its unit, such as '0.031 m', or why there is none."""
        if self.reached is None:
            return f'none: {self.missing}' if self.missing else 'none'
        form = '.0f' if abs(self.reached) >= _LARGE else '.3g'
        return f'{self.reached:{form}} {self.unit}'.rstrip()


@dataclass(frozen=True)
class RobotPath:
    """Path of a robot, thinned out and rounded for pictures.

    Attributes:
        robot: Number of the robot.
        own: Points (x, y) in m of the submission's run; empty if there was none.
        wanted: Those of the model solution's run.
    """

    robot: int
    own: tuple[tuple[float, float], ...]
    wanted: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class ScenarioMark:
    """The marks of one scenario.

    Attributes:
        name: That of the scenario.
        criteria: A mark for each of its criteria, in their order.
        failure: The first thing that went wrong in its run; None if nothing did.
        paths: Of each robot; empty if the scenario is hidden.
        hidden: Whether students see nothing of it but its points.
    """

    name: str
    criteria: tuple[CriterionMark, ...]
    failure: Failure | None = None
    paths: tuple[RobotPath, ...] = ()
    hidden: bool = False

    @property
    def points(self) -> float:
        """The points of all its criteria."""
        return _sum(mark.points for mark in self.criteria)

    @property
    def max_points(self) -> float:
        """What could be reached."""
        return _sum(mark.max_points for mark in self.criteria)


@dataclass(frozen=True)
class Similar:
    """Another script that a submission is like.

    Attributes:
        submission: That submission, or 'the built-in law NAME'.
        share: How much of it is the same, from 0 to 1.
    """

    submission: str
    share: float


@dataclass(frozen=True)
class Marks:
    """The marks of a submission.

    Attributes:
        submission: Its file or folder, relative to the folder of the class.
        student: Whose it is.
        title: That of the rubric.
        scenarios: A mark for each scenario, in their order, also for those that were not run.
        failure: Why nothing of it could be run; None if it could.
        unfilled: Whether it is an exercise that is not filled in yet; it has no points then.
        similar: What it is like.
        digest: Of the script with its helper modules, and the rubric with its files.
    """

    submission: str
    student: Student
    title: str
    scenarios: tuple[ScenarioMark, ...]
    failure: Failure | None = None
    unfilled: bool = False
    similar: tuple[Similar, ...] = ()
    digest: str = ''

    @property
    def score(self) -> float:
        """The points of all scenarios."""
        return _sum(mark.points for mark in self.scenarios)

    @property
    def max_score(self) -> float:
        """What could be reached."""
        return _sum(mark.max_points for mark in self.scenarios)

    @property
    def is_full(self) -> bool:
        """Whether all points were reached."""
        return all(mark.is_full for one in self.scenarios for mark in one.criteria)


@dataclass(frozen=True)
class ScenarioRun:
    """What became of the run of a scenario.

    Attributes:
        run: The run, as far as it came; None if there is nothing of it.
        failure: The first thing that went wrong; None if nothing did.
        is_complete: Whether it reached its end. A run that the script has ended (dead, hung,
            forged) is not, and has no points.
    """

    run: Run | None
    failure: Failure | None = None
    is_complete: bool = True


class LawRunner(Protocol):
    """Runs scenarios with a submission, wherever that lives: this process, a sandbox, robots.

    `setcmas_tools.grade.marking.mark(rubric, run, submission, student)` calls it for each
    scenario in turn and returns the Marks, computed from the runs in the process that it is called
    in; `unmarked(rubric, submission, student, failure)` those of a submission that cannot be run
    at all. A runner must not raise for anything that a script does; SetcmasError is for the
    teacher's mistakes and ends the grading.
    """

    def __call__(self, scenario: MarkedScenario) -> ScenarioRun:
        """Return the run of a scenario with the submission."""


def _sum(points: Iterable[float]) -> float:
    return round(sum(points), _DIGITS)
