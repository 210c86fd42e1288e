"""Marking: from the runs of a submission, compared with those of the solution, to its marks.

Answers are compared at the calls of the submission: the solution gets the poses and messages that
the submission got, so that neither the paths nor the timing of earlier calls matter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.altered_solutions import SOLUTION, Altered, Calls, calls_of, saturated
from setcmas_tools.grade.criteria import COMPARED, OF_ANSWERS, Criterion, figures_of
from setcmas_tools.grade.diagnosis import diagnosis
from setcmas_tools.grade.mark_records import (
    CriterionMark,
    Failure,
    LawRunner,
    Marks,
    RobotPath,
    ScenarioMark,
    ScenarioRun,
)
from setcmas_tools.grade.rubric import MarkedScenario, Rubric
from setcmas_tools.measures.comparison import distances_between
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run
from setcmas_tools.study.study_columns import COLUMNS
from setcmas_tools.submissions.notebook import in_cells
from setcmas_tools.submissions.submissions import Submission

_POINTS = 150  # of a path in a picture, at most
_DECIMALS = 3  # mm
_STILL_M = 1e-3
_NOTHING = ScenarioRun(None)


def mark(rubric: Rubric, run: LawRunner, submission: Submission) -> Marks:
    """Return the marks of a submission, which runs only if it has a script that is filled in.

    Raises:
        SetcmasError: The rubric's solution or a file of it cannot be used.
    """
    if submission.problem or submission.is_unfilled:
        return unmarked(rubric, submission, submission.problem)
    runs = [_with_cells(run(scenario), submission) for scenario in rubric.scenarios]
    marked = [_marked(rubric, *each) for each in zip(rubric.scenarios, runs, strict=True)]
    scenarios, file = _hinted(rubric, marked, runs), submission.file
    return Marks(submission.name, submission.student, rubric.title, scenarios, file=file)


def unmarked(rubric: Rubric, submission: Submission, problem: str = '') -> Marks:
    """Return marks without points, for a submission that cannot run, or is not filled in."""
    return Marks(
        submission.name,
        submission.student,
        rubric.title,
        tuple(_marked(rubric, scenario, _NOTHING) for scenario in rubric.scenarios),
        failure=Failure(problem) if problem else None,
        unfilled=not problem,
        file=submission.file,
    )


def _with_cells(done: ScenarioRun, submission: Submission) -> ScenarioRun:
    """Return a run whose failure names the cell of a notebook, if the submission is one."""
    notebook, failure = submission.notebook, done.failure
    if not notebook or not failure:
        return done
    message = in_cells(failure.message, PurePosixPath(submission.file).name, notebook)
    return replace(done, failure=replace(failure, message=message))


def _hinted(
    rubric: Rubric, marks: Sequence[ScenarioMark], runs: Sequence[ScenarioRun]
) -> tuple[ScenarioMark, ...]:
    """Return marks with a hint at the first missed criterion that students see.

    A failing script gets none, which would distract from its error.
    """
    known = {
        scenario.name: (scenario, done.run)
        for scenario, done in zip(rubric.scenarios, runs, strict=True)
        if done.run and done.is_complete and not done.failure and not scenario.hidden
    }
    for place, scenario in enumerate(marks):
        missed = [one for one in scenario.criteria if not (one.is_full or one.hidden)]
        if missed and scenario.name in known:
            [own] = [one for one in known[scenario.name][0].criteria if one.name == missed[0].name]
            text = diagnosis(rubric, [*known.values()], own.hint)
            hinted = replace(missed[0], hint=text or missed[0].hint)
            criteria = (hinted if one is missed[0] else one for one in scenario.criteria)
            own_marks = replace(scenario, criteria=tuple(criteria))
            return (*marks[:place], own_marks, *marks[place + 1 :])
    return tuple(marks)


def _marked(rubric: Rubric, scenario: MarkedScenario, done: ScenarioRun) -> ScenarioMark:
    solution = rubric.solution_run(scenario)
    figures: dict[str, float | None] = {}
    # If a condition fails, the engine sends the state, so the result is not the student's.
    is_own = rubric.function is not Function.CONDITION or not done.failure
    if done.run and done.is_complete and is_own:
        if solution:  # whatever references its own script declares
            figures = figures_of(replace(done.run, references=solution.references))
            figures |= compared(scenario, done.run, solution, rubric.solution, rubric.function)
        else:
            figures = figures_of(done.run)
    return ScenarioMark(
        scenario.name,
        _criteria(scenario.criteria, figures, done),
        done.failure,
        () if scenario.hidden else _paths(done.run, solution),
        scenario.hidden,
    )


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
        return 'the script failed'
    if done.run is None:
        return 'it did not run'
    column = COLUMNS.get(metric)
    is_of_messages = column is not None and column.metric == 'messages'
    if (figures.get('path_length') or 0.0) < _STILL_M and not is_of_messages:
        return 'no robot moved'
    return 'it never got there' if column and column.endless else ''


def _paths(run: Run | None, solution: Run | None) -> tuple[RobotPath, ...]:
    own, wanted = (
        {robot: _thinned(one, robot) for robot in one.robots} if one else {}
        for one in (run, solution)
    )
    robots = sorted({*own, *wanted})
    return tuple(RobotPath(i, own.get(i, ()), wanted.get(i, ())) for i in robots)


def _thinned(run: Run, robot: int) -> tuple[tuple[float, float], ...]:
    """Return points of the path of a robot: its first, its last, and some between."""
    path = np.column_stack([run.table.of(robot).x, run.table.of(robot).y])
    known = path[np.isfinite(path).all(axis=1)]
    chosen = np.linspace(0, len(known) - 1, min(len(known), _POINTS)).round().astype(int)
    points = np.round(known[chosen], _DECIMALS) + 0.0
    return tuple((x, y) for x, y in points.tolist())


_COMPARED_DECIMALS = 6  # fewer than the last bits, in which machines and sandboxes differ
_LEAST_M_S = 0.05  # slower velocities do not count: laws may have dead bands
_STILL_M_S = 1e-3  # slower velocities have no direction


def compared(
    scenario: MarkedScenario, run: Run, solution: Run, script: Path | None, function: Function
) -> dict[str, float | None]:
    """Return comparisons that criteria ask for by name, with 6 decimals; None for missing ones.

    Args:
        scenario: The scenario and its criteria.
        run: The run of the submission.
        solution: The run of the solution.
        script: The solution; None is the default condition or si_to_uni, or unknown.
        function: What answers: a control law, a triggering condition, or si_to_uni.
    """
    names = COMPARED.keys() & {one.metric for one in scenario.criteria}
    _, apart = distances_between(run, solution)
    distances = np.array([*apart.values()])
    if not np.isfinite(distances).any():
        return dict.fromkeys(names)
    calls, is_law = None, function is Function.CONTROL
    if names & {*OF_ANSWERS} and (script or not is_law):
        right = Altered(SOLUTION, script, is_kept=True)
        calls = calls_of('', scenario.base, run, function, [right])
    if calls and scenario.robots:
        calls = calls.of_robots(np.isin(np.arange(calls.own.shape[1]) + 1, scenario.robots))
    answer_error = _sending_error if function is Function.CONDITION else _velocity_error
    measures: dict[str, Callable[[], float | None]] = {
        'path_error': lambda: np.sqrt(np.nanmean(distances**2)),
        'end_error': lambda: np.nanmax(distances[:, -1]),
        'path_ratio': lambda: _ratio(run, solution),
        'path_distance': lambda: _path_distance(run, solution),
        'answer_error': lambda: answer_error(calls) if calls else None,
        'direction_error': lambda: _direction_error(calls) if calls and is_law else None,
    }
    found = {name: measures[name]() for name in names}
    return {
        name: None if number is None else round(float(number), _COMPARED_DECIMALS)
        for name, number in found.items()
    }


def _ratio(run: Run, solution: Run) -> float | None:
    grids = (run.counted_grid, solution.counted_grid)
    own, wanted = (float(np.nansum(np.hypot(np.diff(g.x), np.diff(g.y)))) for g in grids)
    return own / wanted if wanted else None


def _path_distance(run: Run, solution: Run) -> float:
    """Return the largest distance of a robot from the path of the solution in m."""
    own, wanted = (_paths_of(one.counted_grid) for one in (run, solution))
    robots = own.keys() & wanted.keys()
    gaps = [np.hypot(*(own[i][:, None] - wanted[i]).transpose(2, 0, 1)) for i in robots]
    return max(float(one.min(axis=1).max()) for one in gaps)


def _paths_of(grid: FleetGrid) -> dict[int, Floats]:
    """Return the known positions of each robot, shape (K, 2)."""
    rows = zip(grid.robots, grid.x, grid.y, strict=True)
    return {robot: np.column_stack([x, y])[np.isfinite(x + y)] for robot, x, y in rows}


def _velocity_error(calls: Calls) -> float:
    """Return the median relative difference of answers, of the robot where it is largest.

    The median leaves freedom in moments such as turns, and when a law changes its target.
    """
    return max(_relative(*each, calls.limit) for each in _by_robot(calls))


def _direction_error(calls: Calls) -> float:
    """Return the median angle between velocities in degrees, its mean over the robots.

    It does not depend on gains.
    """
    return float(np.mean([_angle(*each) for each in _by_robot(calls)]))


def _sending_error(calls: Calls) -> float:
    """Return the share of wrong decisions among those at which a state is or must be sent."""
    does, must = calls.own[..., 0] == 1, calls.solution[..., 0] == 1
    firsts = does.shape[1]  # which are sent whatever the condition is
    return float((does != must).sum() / (firsts + (does | must).sum()))


def _by_robot(calls: Calls) -> Iterator[tuple[Floats, Floats]]:
    """Yield each robot's velocities and those of the solution, shape (C, 2)."""
    for robot in range(calls.own.shape[1]):
        yield calls.own[:, robot], calls.solution[:, robot]


def _angle(own: Floats, wanted: Floats) -> float:
    """Return the median angle between velocities in degrees, both of shape (C, 2).

    Calls at which the solution is slow do not count; a robot without a velocity is wrong by 180.
    """
    cross = own[:, 0] * wanted[:, 1] - own[:, 1] * wanted[:, 0]
    apart = np.degrees(np.abs(np.arctan2(cross, np.sum(own * wanted, axis=1))))
    apart[np.hypot(*own.T) < _STILL_M_S] = 180.0
    counted = apart[np.hypot(*wanted.T) > _LEAST_M_S]
    return float(np.median(counted)) if len(counted) else 0.0


def _relative(own: Floats, wanted: Floats, vnom: float) -> float:
    """Return the median of |own - wanted| as a share of the faster; both have shape (C, 2).

    Slow velocities do not count, and saturated ones, which hide gains, only if all are.
    """
    speeds = np.hypot(*wanted.T)
    is_free = (speeds > _LEAST_M_S) & (speeds < vnom)
    apart = np.hypot(*(own - saturated(wanted, vnom)).T)
    faster = np.maximum(np.hypot(*own.T), np.minimum(speeds, vnom))
    counted = is_free if is_free.any() else faster > _LEAST_M_S
    shares = apart[counted] / faster[counted]
    return float(np.median(shares)) if len(shares) else 0.0
