"""Check of a student's own law."""

from __future__ import annotations

import html
import io
import math
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from setcmas_ctrl.laws.exercise import exercise_of, is_unfilled
from setcmas_ctrl.laws.script_imports import calling_robot
from setcmas_ctrl.laws.script_loader import EXERCISES
from setcmas_ctrl.laws.script_output import folded_output
from setcmas_ctrl.laws.script_search import find_script
from setcmas_simu.errors import SetcmasError, did_you_mean, file_errors, needs
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.criteria import COMPARED, OF_ANSWERS, points_text, rounded
from setcmas_tools.grade.mark_records import (
    CriterionMark,
    Failure,
    LawRunner,
    Marks,
    ScenarioMark,
    ScenarioRun,
)
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.rubric import (
    MarkedScenario,
    Rubric,
    read_rubric,
    rubric_of_exercise,
)
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.run_info import RunState
from setcmas_tools.submissions.student import Student

if TYPE_CHECKING:
    from setcmas_tools.submissions.submissions import Submission


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
    points = rounded(sum(mark.points for mark in criteria))
    most = rounded(sum(mark.max_points for mark in criteria))
    return CriterionMark(name, points, most, '', '', None, hidden=True)


_WITHIN = (
    'a law that is being marked cannot call check(); put this line below '
    "`if __name__ == '__main__':`"
)
_TICK, _CROSS = '✓', '✗'
_WIDTH = 90
_DPI = 55


@dataclass(frozen=True)
class Check:
    """Marks of one's own law as text, as picture, and in notebooks.

    Attributes:
        marks: The marks.
        hidden_points: Points of the hidden parts of the rubric, which do not count.
    """

    marks: Marks
    hidden_points: float = 0.0

    def __str__(self) -> str:
        """Return a line per criterion, and hints below missed ones."""
        return '\n'.join(lines_of(self.marks, self.hidden_points))

    def plain(self) -> dict[str, Any]:
        """Return the check for `setcmas check --json`: texts, numbers, lists and dictionaries."""
        marks = self.marks
        return {
            'title': marks.title,
            'submission': marks.submission,
            'status': self._status,
            'score': marks.score,
            'max_score': marks.max_score,
            'scenarios': [_plain(one) for one in marks.scenarios],
        }

    @property
    def _status(self) -> str:
        if self.marks.unfilled:
            return 'unfilled'
        if any(one.failure for one in self.marks.scenarios):
            return 'failed'
        return 'right' if self.marks.is_full else 'incomplete'

    __repr__ = __str__  # in a terminal, where notebooks show HTML

    def picture_url(self) -> str:
        """Return a picture of the paths over those of the solution, as the data URL of a PNG."""
        from setcmas_tools.grade.mark_pictures import picture_url

        return picture_url(self.marks, _DPI)

    def _repr_html_(self) -> str:
        return (
            f'<div><pre style="line-height:1.3">{html.escape(str(self))}</pre>'
            f'<img src="{self.picture_url()}" '
            'alt="your paths over those of the solution"></div>'
        )


def _plain(scenario: ScenarioMark) -> dict[str, Any]:
    return {
        'name': scenario.name,
        'score': scenario.points,
        'max_score': scenario.max_points,
        'failure': scenario.failure.message if scenario.failure else '',
        'criteria': [
            {
                'name': one.name,
                'score': one.points,
                'max_score': one.max_points,
                'metric': one.metric,
                'wanted': one.wanted,
                'reached': one.reached if math.isfinite(one.reached or 0.0) else None,
                'unit': one.unit,
                'hint': one.hint,
            }
            for one in scenario.criteria
        ],
    }


def check(law: str | Path | Callable[..., Any], rubric: str | Path | None = None) -> Check:
    """Mark your own law by the visible part of its rubric.

        from setcmas_tools import check

            check('my_law.py')                # by the exercise that it names, or a notebook
            check(control, 'consensus')       # a function in a notebook

    Args:
        law: A script, a notebook, or a function `control`, `ctc` or `si_to_uni`. It runs in this
            process.
        rubric: An exercise or a file; by default the exercise that the script names.

    Raises:
        SetcmasError: The law or rubric does not exist, or cannot be read.
        RuntimeError: A law that is marked calls it.
    """
    if calling_robot() is not None:
        raise RuntimeError(_WITHIN)
    if callable(law):
        chosen = chosen_rubric(None, rubric).shown()
        name = getattr(law, '__name__', chosen.function.value)
        run = runs_here(law, chosen.function)
        return Check(mark(chosen, run, name, Student(name)), chosen.hidden_points)
    with opened(str(law)) as own:
        chosen = chosen_rubric(own.script, rubric).shown()
        marks = own.marks(chosen, runs_here(str(own.script), chosen.function))
        return Check(marks, chosen.hidden_points)


@dataclass(frozen=True)
class OwnLaw:
    """A student's own law.

    Attributes:
        name: Its script or notebook.
        script: The script, or that of the notebook's cells.
        notebook: The notebook as a submission; None for a script.
    """

    name: str
    script: Path
    notebook: Submission | None = None

    def marks(self, rubric: Rubric, run: LawRunner) -> Marks:
        """Return its marks; messages name the cells of a notebook."""
        if self.notebook:
            from setcmas_tools.grade.class_grading import named_cells

            run = named_cells(run, self.notebook)
        unfilled = is_unfilled(self.script, rubric.exercise)
        return mark(rubric, run, self.name, Student(self.name), unfilled)


@contextmanager
def opened(law: str) -> Iterator[OwnLaw]:
    """Open a script, by path or name, or a notebook, or raise SetcmasError."""
    path = Path(law)
    if path.suffix != '.ipynb' or not path.is_file():
        script = find_script(law)
        yield OwnLaw(script.name, script)
        return
    with needs('grade'):
        from setcmas_tools.submissions.notebook import in_cells
        from setcmas_tools.submissions.submissions import submitted_notebook
    with file_errors(f"'{law}' cannot be read"):
        submission = submitted_notebook(path)
    with submission.unpacked() as script:
        try:
            yield OwnLaw(path.name, script, submission)
        except SetcmasError as error:
            if not submission.notebook:
                raise
            message = in_cells(str(error), path.name, submission.notebook)
            raise SetcmasError(message) from error


def runs_here(submission: Any, function: Function = Function.CONTROL) -> LawRunner:
    """Return a runner of scenarios for a trusted submission, in this process, as `simulate` does.

    The submission is what `MarkedScenario.with_submission` takes.
    """

    def run(scenario: MarkedScenario) -> ScenarioRun:
        messages: list[str] = []
        try:
            with folded_output():
                made = simulate(
                    scenario.with_submission(submission, function), warn=messages.append
                )
        except SetcmasError as error:
            return ScenarioRun(None, Failure(str(error)), is_complete=False)
        return ScenarioRun(made, Failure(messages[0]) if messages else None)

    return run


def runs_apart(script: Path, rubric: Rubric, call_timeout: float) -> LawRunner:
    """Return a runner of scenarios with a script in processes of their own.

    The script can hang or die without harm: a call that takes longer than `call_timeout`, in s,
    ends a run. The runner raises SetcmasError if the script cannot be loaded.
    """
    from setcmas_tools.offline.offline_run import OfflineRun

    def run(scenario: MarkedScenario) -> ScenarioRun:
        chosen = scenario.with_submission(str(script), rubric.function).found()
        messages: list[str] = []
        nowhere = io.StringIO()
        with redirect_stderr(nowhere), folded_output(), OfflineRun(chosen) as offline_run:
            made = offline_run.result(call_timeout, messages.append)
        if made.outcome.state is RunState.DIED:
            return ScenarioRun(made, Failure(made.outcome.detail), is_complete=False)
        return ScenarioRun(made, Failure(messages[0]) if messages else None)

    return run


def chosen_rubric(script: Path | None, rubric: str | Path | None) -> Rubric:
    """Return the rubric with this name or file, or of the exercise that a script names.

    Raises:
        SetcmasError: There is none.
    """
    if rubric is not None and str(rubric) in EXERCISES:
        return rubric_of_exercise(str(rubric))
    if rubric is not None:
        names = EXERCISES.plugins()
        if not Path(rubric).exists():
            hint = did_you_mean(rubric, names) or f'; give a file, or one of {", ".join(names)}'
            raise SetcmasError(f"there is no rubric '{rubric}'{hint}")
        return read_rubric(Path(rubric))
    if script and (exercise := exercise_of(script)):
        return rubric_of_exercise(exercise)
    known = ', '.join(EXERCISES.plugins())
    what = f'{script.name} names no exercise' if script else 'a function names no exercise'
    raise SetcmasError(
        f'{what}; give a rubric, or one of {known} (in a script, name it in a line such '
        "as exercise = 'consensus')"
    )


def lines_of(marks: Marks, hidden_points: float = 0.0) -> Iterator[str]:
    """Yield marks as students read them, in a terminal and on a learning platform."""
    yield f'{marks.title}: {marks.own_file or marks.submission}'
    if marks.unfilled:
        yield f'{_CROSS} not filled in yet: replace the parts marked TODO'
    elif marks.failure:
        yield f'not marked: {marks.failure.text}'
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
            yield textwrap.indent(scenario.failure.text, '  ')
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
