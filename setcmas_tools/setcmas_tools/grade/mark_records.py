"""Marks of a submission: wanted and measured values, and points, for each criterion.

All classes are frozen and have plain values, which msgspec writes and reads (`msgspec.json`).
Equal submissions get equal marks: nothing depends on the clock, the machine or the folder.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from setcmas_tools.grade.criteria import (
    COMPARED,
    OF_ANSWERS,
    points_text,
    quantity_text,
    rounded,
)
from setcmas_tools.grade.rubric import MarkedScenario
from setcmas_tools.run.run import Run
from setcmas_tools.submissions.likeness import Similar
from setcmas_tools.submissions.submitted_files import Student


@dataclass(frozen=True)
class Failure:
    """An error of a script.

    Attributes:
        message: Message of setcmas, with the line; may have several lines and contain anything.
        robot: Number of the robot, from 1; 0 for no particular robot.
        t: Time in s of the run; None if it did not start.
    """

    message: str
    robot: int = 0
    t: float | None = None

    @property
    def reason(self) -> str:
        """The first line of the message."""
        return self.message.strip().partition('\n')[0]


@dataclass(frozen=True)
class CriterionMark:
    """The mark for one criterion.

    Attributes:
        metric: Measured quantity, such as 'disagreement'.
        wanted: Its bounds as text, such as 'at most 0.05 m'.
        reached: Its value; None if there is none.
        hint: Hint for the student; '' for full points or a failed script.
        hidden: Whether students only see its points.
        missing: Why there is no value; '' if unknown.
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
        """Whether it has all points: a tick, otherwise a cross."""
        return self.points == self.max_points

    @property
    def reached_text(self) -> str:
        """The value with its unit, such as '0.031 m', or why there is none."""
        if self.reached is None:
            return f'none: {self.missing}' if self.missing else 'none'
        return quantity_text(self.reached, self.metric)


@dataclass(frozen=True)
class RobotPath:
    """Points (x, y) in m of a robot's path, thinned out and rounded for pictures.

    Attributes:
        own: In the submission's run; empty without a run.
        wanted: In the model solution's run.
    """

    robot: int
    own: tuple[tuple[float, float], ...]
    wanted: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class ScenarioMark:
    """The marks of one scenario.

    Attributes:
        failure: First error of its run; None without errors.
        paths: Paths of the robots; empty if the scenario is hidden.
        hidden: Whether students only see its points.
        picture: The paths as the data URL of a picture; '' until a class is graded.
    """

    name: str
    criteria: tuple[CriterionMark, ...]
    failure: Failure | None = None
    paths: tuple[RobotPath, ...] = field(default=(), repr=False)  # thousands of numbers
    hidden: bool = False
    picture: str = field(default='', repr=False)

    @property
    def points(self) -> float:
        """Total points of its criteria."""
        return _sum(mark.points for mark in self.criteria)

    @property
    def max_points(self) -> float:
        """Largest possible points."""
        return _sum(mark.max_points for mark in self.criteria)

    @property
    def points_text(self) -> str:
        """Its points, such as '4.5 of 7 points'."""
        return f'{points_text(self.points)} of {points_text(self.max_points)} points'


@dataclass(frozen=True)
class Correction:
    """Points that a person has added to a mark, or taken, and why.

    Attributes:
        what: What was corrected, such as 'bonus', or a scenario and its criterion.
        points: Points added; below 0 if taken.
        date: Day, such as '2026-11-22'.
        hidden: Whether students do not see what was corrected.
    """

    what: str
    points: float
    reason: str
    author: str
    date: str
    hidden: bool = False

    def __str__(self) -> str:
        text = f'{self.points:+.2f}'.rstrip('0').rstrip('.')
        return f'{self.what} {text}: {self.reason} ({self.author}, {self.date})'


@dataclass(frozen=True)
class Marks:
    """The marks of a submission.

    Attributes:
        submission: Its name: a file or folder of the class, or the student's name and number.
        title: Title of the rubric.
        scenarios: Marks for all scenarios, in order, even if they were not run.
        failure: Why nothing could run; None if it could.
        unfilled: Whether it is an exercise that is not filled in yet; then it has no points.
        corrections: Changes by a person, in order; stored marks have none.
        file: The file that was marked, in the submission; '' if there is none.
    """

    submission: str
    student: Student
    title: str
    scenarios: tuple[ScenarioMark, ...]
    failure: Failure | None = None
    unfilled: bool = False
    similar: tuple[Similar, ...] = ()
    corrections: tuple[Correction, ...] = ()
    file: str = ''

    @property
    def is_decided(self) -> bool:
        """Whether it has a grade: something could run, or a person has decided."""
        return not self.failure or bool(self.corrections)

    @property
    def automatic(self) -> float:
        """Total points of all scenarios, before corrections."""
        return _sum(mark.points for mark in self.scenarios)

    @property
    def score(self) -> float:
        """Total points after corrections."""
        return _sum([self.automatic, *(one.points for one in self.corrections)])

    @property
    def max_score(self) -> float:
        """Largest possible points."""
        return _sum(mark.max_points for mark in self.scenarios)

    @property
    def points_text(self) -> str:
        """Its points, such as '8 of 10 points'."""
        return f'{points_text(self.score)} of {points_text(self.max_score)} points'

    @property
    def is_full(self) -> bool:
        """Whether it has all points."""
        if self.corrections:
            return self.score >= self.max_score
        return all(mark.is_full for one in self.scenarios for mark in one.criteria)

    def __repr__(self) -> str:
        """Return one line."""
        return f'Marks({self.title}, {self.submission}, {self.points_text})'


def student_view(marks: Marks) -> Marks:
    """Return the parts of marks that students may see; the scores stay.

    Hidden criteria of a scenario become one criterion without value; hidden scenarios become one
    scenario with one criterion.
    """
    shown = [_without_hidden(one) for one in marks.scenarios if not one.hidden]
    hidden = [mark for one in marks.scenarios if one.hidden for mark in one.criteria]
    if hidden:
        together = (_together(hidden, 'all hidden scenarios'),)
        shown.append(ScenarioMark('Hidden scenarios', together, hidden=True))
    corrections = tuple(
        replace(one, what='hidden criteria') if one.hidden else one for one in marks.corrections
    )
    return replace(marks, scenarios=tuple(shown), similar=(), corrections=corrections)


def _without_hidden(scenario: ScenarioMark) -> ScenarioMark:
    shown = [mark for mark in scenario.criteria if not mark.hidden]
    hidden = [mark for mark in scenario.criteria if mark.hidden]
    if hidden:
        shown.append(_together(hidden, 'hidden criteria'))
    return replace(scenario, criteria=tuple(shown))


def _together(criteria: Sequence[CriterionMark], name: str) -> CriterionMark:
    points = _sum(mark.points for mark in criteria)
    most = _sum(mark.max_points for mark in criteria)
    return CriterionMark(name, points, most, '', '', None, hidden=True)


_TICK, _CROSS = '✓', '✗'
_WIDTH = 90


def lines_of(marks: Marks, hidden_points: float = 0.0) -> Iterator[str]:
    """Yield marks as students read them, in a terminal and on a learning platform."""
    yield f'{marks.title}: {marks.file or marks.submission}'
    if marks.unfilled:
        yield f'{_CROSS} not filled in yet: replace the parts marked TODO'
    elif marks.failure:
        yield f'not marked: {marks.failure.message}'
    else:
        yield from _scenarios_lines(marks.scenarios)
    if marks.corrections:
        yield f'automatic mark: {points_text(marks.automatic)}; corrections:'
        yield from map(str, marks.corrections)
    if marks.is_decided and not (marks.unfilled and not marks.corrections):
        more = (
            f'; {points_text(hidden_points)} more are for hidden parts, which setcmas grade marks'
        )
        yield f'{marks.points_text}{more if hidden_points else ""}'


def _scenarios_lines(scenarios: Sequence[ScenarioMark]) -> Iterator[str]:
    for scenario in scenarios:
        yield ''
        yield f'{scenario.name}: {scenario.points_text}'
        if scenario.failure:
            yield textwrap.indent(scenario.failure.message, '  ')
        for one in scenario.criteria:
            sign = _TICK if one.is_full else _CROSS
            points = f'{points_text(one.points)}/{points_text(one.max_points)}'
            figures = f': {one.metric} {one.reached_text} (wanted: {one.wanted})'
            yield f'  {sign} {points}  {one.name}{"" if one.hidden else figures}'
            if one.hint:
                yield textwrap.indent(textwrap.fill(one.hint, _WIDTH), 6 * ' ')
    yield ''
    missed = (one for scenario in scenarios for one in scenario.criteria if not one.is_full)
    for metric in dict.fromkeys(one.metric for one in missed if one.metric in OF_ANSWERS):
        yield textwrap.fill(f'{metric}: {COMPARED[metric][1]}', _WIDTH, subsequent_indent='  ')


@dataclass(frozen=True)
class ScenarioRun:
    """Result of running a scenario.

    Attributes:
        run: The run, as far as it came; None if there is none.
        failure: First error; None without errors.
        is_complete: Whether it reached its end. A run that the script ended (died, hung,
            forged) did not, and gets no points.
    """

    run: Run | None
    failure: Failure | None = None
    is_complete: bool = True


LawRunner = Callable[[MarkedScenario], ScenarioRun]
"""Runs scenarios with a submission: in this process or in a sandbox.

Errors of a script raise nothing; SetcmasError means a mistake of the teacher or a fault of the
machine.
"""


def _sum(points: Iterable[float]) -> float:
    return rounded(sum(points))
