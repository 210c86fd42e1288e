"""Marking: from the runs of a submission to its marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.grade.criteria import Criterion, figures_of
from setcmas_tools.grade.diagnosis import diagnosis
from setcmas_tools.grade.marks import (
    CriterionMark,
    Failure,
    LawRunner,
    Marks,
    RobotPath,
    ScenarioMark,
    ScenarioRun,
)
from setcmas_tools.grade.rubric import CTC, MarkedScenario, Rubric
from setcmas_tools.grade.solution_comparison import compared
from setcmas_tools.run.run import Run
from setcmas_tools.study.study_columns import COLUMNS
from setcmas_tools.submissions.student import Student

_POINTS = 150  # of a path in a picture, at most
_DECIMALS = 3  # mm
_STILL_M = 1e-3
_NOTHING = ScenarioRun(None)


def mark(
    rubric: Rubric, run: LawRunner, submission: str, student: Student, is_unfilled: bool = False
) -> Marks:
    """Return the marks of a submission; an exercise that is still unfilled is not run.

    Raises:
        SetcmasError: The rubric's solution or a file of it cannot be used.
    """
    if is_unfilled:
        return replace(unmarked(rubric, submission, student), unfilled=True)
    runs = [run(scenario) for scenario in rubric.scenarios]
    scenarios = [_marked(rubric, *each) for each in zip(rubric.scenarios, runs, strict=True)]
    return Marks(submission, student, rubric.title, _hinted(rubric, scenarios, runs))


def unmarked(
    rubric: Rubric, submission: str, student: Student, failure: Failure | None = None
) -> Marks:
    """Return marks without points, for a submission that cannot run because of a failure."""
    scenarios = tuple(_marked(rubric, scenario, _NOTHING) for scenario in rubric.scenarios)
    return Marks(submission, student, rubric.title, scenarios, failure)


def _hinted(
    rubric: Rubric, marks: Sequence[ScenarioMark], runs: Sequence[ScenarioRun]
) -> tuple[ScenarioMark, ...]:
    """Return marks with a hint at the first missed criterion that students see.

    A failing script gets none, which would distract from its error.
    """
    pairs = list(zip(rubric.scenarios, runs, strict=True))
    known = [
        (one.name, one.base, done.run)
        for one, done in pairs
        if done.run and done.is_complete and not done.failure and not one.hidden
    ]
    names = [name for name, *_ in known]
    for place, scenario in enumerate(marks):
        missed = [one for one in scenario.criteria if not (one.is_full or one.hidden)]
        if missed and scenario.name in names:
            tried = [] if rubric.references else known  # the solution is needed to alter it
            function = Function(rubric.function)
            found = diagnosis(tried, rubric.solution, rubric.mistakes, function)
            [own] = [one for one in pairs[place][0].criteria if one.name == missed[0].name]
            text = found.explanation or ' '.join(filter(None, (found.measured, own.hint)))
            return (*marks[:place], _with_hint(scenario, own.name, text), *marks[place + 1 :])
    return tuple(marks)


def _with_hint(scenario: ScenarioMark, name: str, text: str) -> ScenarioMark:
    hinted = {name: text} if text else {}
    criteria = (replace(one, hint=hinted.get(one.name, one.hint)) for one in scenario.criteria)
    return replace(scenario, criteria=tuple(criteria))


def _marked(rubric: Rubric, scenario: MarkedScenario, done: ScenarioRun) -> ScenarioMark:
    solution = rubric.solution_run(scenario)
    figures: dict[str, float | None] = {}
    # If a condition fails, the engine sends the state, so the result is not the student's.
    is_own = rubric.function != CTC or not done.failure
    if done.run and done.is_complete and is_own:
        figures = figures_of(_with_references_of(done.run, solution))
        if solution:
            names = {one.metric for one in scenario.criteria}
            right = scenario.base, rubric.solution, Function(rubric.function)
            figures |= compared(names, done.run, solution, *right, scenario.robots)
    return ScenarioMark(
        scenario.name,
        _criteria(scenario.criteria, figures, done),
        done.failure,
        () if scenario.hidden else _paths(done.run, solution),
        scenario.hidden,
    )


def _with_references_of(run: Run, solution: Run | None) -> Run:
    """Return a run with the solution's references, whatever its own script declares."""
    if solution is None:
        return run
    return replace(run, tables=replace(run.tables, references=solution.references))


def _criteria(
    criteria: Sequence[Criterion], figures: Mapping[str, float | None], done: ScenarioRun
) -> tuple[CriterionMark, ...]:
    marks: dict[str, CriterionMark] = {}
    for one in criteria:
        reached = figures.get(one.metric)
        points = one.points_for(reached)
        hint = ''
        if points and one.needs and not marks[one.needs].points:
            points, needed = 0.0, marks[one.needs]
            hint = '' if needed.hidden else f"This counts only with points for '{needed.name}'."
        marks[one.name] = CriterionMark(
            one.name, points, one.points, one.metric, one.wanted, reached, one.unit,
            hint, one.hidden, '' if reached is not None else _why_none(one.metric, figures, done),
        )  # fmt: skip
    return tuple(marks.values())


def _why_none(metric: str, figures: Mapping[str, float | None], done: ScenarioRun) -> str:
    """Return why a run has no value of a metric; '' if unknown."""
    if done.failure:
        cell = done.failure.script.partition(', ')[2]
        line = f'line {done.failure.line}' if done.failure.line else ''
        where = ', '.join(part for part in (cell, line) if part)
        return f'the script failed in {where}' if where else 'the script failed'
    if done.run is None:
        return 'it did not run'
    column = COLUMNS.get(metric)
    is_of_messages = column is not None and column.metric == 'messages'
    if (figures.get('path_length') or 0.0) < _STILL_M and not is_of_messages:
        return 'no robot moved'
    return 'it never got there' if column and column.endless else ''


def _paths(run: Run | None, solution: Run | None) -> tuple[RobotPath, ...]:
    own, wanted = (_thinned(one) if one else {} for one in (run, solution))
    robots = sorted({*own, *wanted})
    return tuple(RobotPath(i, own.get(i, ()), wanted.get(i, ())) for i in robots)


def _thinned(run: Run) -> dict[int, tuple[tuple[float, float], ...]]:
    """Return points of the path of each robot: its first, its last, and some between."""
    if not len(run.table.t):
        return {}
    return {robot: _points(run.table.of(robot).x, run.table.of(robot).y) for robot in run.robots}


def _points(x: Floats, y: Floats) -> tuple[tuple[float, float], ...]:
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if not len(known):
        return ()
    chosen = known[np.linspace(0, len(known) - 1, min(len(known), _POINTS)).round().astype(int)]
    points = np.round(np.column_stack([x, y])[chosen], _DECIMALS) + 0.0
    return tuple((px, py) for px, py in points.tolist())
