"""Check of a student's own law."""

from __future__ import annotations

import html
import io
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_imports import calling_robot
from setcmas_ctrl.laws.script_output import limited_output
from setcmas_ctrl.laws.script_search import find_script, is_unfilled
from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.mark_records import (
    Failure,
    LawRunner,
    Marks,
    ScenarioRun,
    lines_of,
)
from setcmas_tools.grade.marking import mark
from setcmas_tools.grade.rubric import MarkedScenario, Rubric, chosen_rubric
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.run_info import RunState
from setcmas_tools.submissions.notebook import in_cells
from setcmas_tools.submissions.submissions import Submission, submitted_notebook
from setcmas_tools.submissions.submitted_files import Student

_WITHIN = (
    'a law that is being marked cannot call check(); put this line below '
    "`if __name__ == '__main__':`"
)
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
        """Return the check as JSON has it, for `setcmas check --json` and pages in a browser.

        It has no paths; values that JSON does not have are None.
        """
        marks = asdict(self.marks)
        for plain, scenario in zip(marks['scenarios'], self.marks.scenarios, strict=True):
            plain['paths'] = ()
            for criterion, one in zip(plain['criteria'], scenario.criteria, strict=True):
                criterion['reached_text'] = one.reached_text
                if not math.isfinite(one.reached or 0.0):
                    criterion['reached'] = None
        return {
            'status': self.status,
            'score': self.marks.score,
            'max_score': self.marks.max_score,
            'marks': marks,
        }

    @property
    def status(self) -> str:
        """A word for programs: unfilled, failed, incomplete or right."""
        if self.marks.unfilled:
            return 'unfilled'
        if any(one.failure for one in self.marks.scenarios):
            return 'failed'
        return 'right' if self.marks.is_full else 'incomplete'

    __repr__ = __str__  # in a terminal, where notebooks show HTML

    def picture_url(self) -> str:
        """Return a picture of the paths over those of the solution, as the data URL of a PNG.

        '' if no scenario has paths.
        """
        from setcmas_tools.grade.mark_pictures import picture_url

        return picture_url(self.marks.scenarios, _DPI)

    def _repr_html_(self) -> str:
        text = f'<pre style="line-height:1.3">{html.escape(str(self))}</pre>'
        if url := self.picture_url():
            text += f'<img src="{url}" alt="your paths over those of the solution">'
        return f'<div>{text}</div>'


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
        marks = mark(chosen, run, Submission(name, Student(name)))
        return Check(marks, chosen.hidden_points)
    with opened(str(law)) as (script, submission):
        chosen = chosen_rubric(script, rubric).shown()
        run = runs_here(str(script), chosen.function)
        return Check(marks_of(script, chosen, run, submission), chosen.hidden_points)


def marks_of(
    script: Path, rubric: Rubric, run: LawRunner, submission: Submission | None = None
) -> Marks:
    """Return the marks of a script, or of a notebook that it stands for.

    Messages name the cells of a notebook.
    """
    own = submission or Submission(script.name, Student(script.name))
    is_empty = is_unfilled(script, rubric.exercise)
    return mark(rubric, run, replace(own, is_unfilled=is_empty))


@contextmanager
def opened(law: str) -> Iterator[tuple[Path, Submission | None]]:
    """Open a script, by path or name, or the script and submission that a notebook is.

    Raises:
        SetcmasError: It cannot be read, or is no notebook.
    """
    path = Path(law)
    if path.suffix != '.ipynb' or not path.is_file():
        yield find_script(law), None
        return
    with file_errors(f"'{law}' cannot be read"):
        submission = submitted_notebook(path)
    with submission.unpacked() as script:
        try:
            yield script, submission
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
            with limited_output():
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
        with redirect_stderr(nowhere), limited_output(), OfflineRun(chosen) as offline_run:
            made = offline_run.result(messages.append, call_timeout)
        if made.outcome.state is RunState.DIED:
            return ScenarioRun(made, Failure(made.outcome.detail), is_complete=False)
        return ScenarioRun(made, Failure(messages[0]) if messages else None)

    return run
