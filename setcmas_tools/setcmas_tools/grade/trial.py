"""Trial of a script as `setcmas grade` runs it, so that `check` shows what it would refuse."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from setcmas_ctrl.scripts.imports import with_helpers
from setcmas_tools.grade.class_grading import Grader
from setcmas_tools.grade.criteria import points_text
from setcmas_tools.grade.marks import Failure, Marks
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.grade.sandbox import SandboxRunner, Times, sandbox
from setcmas_tools.offline.child_channel import MachineError
from setcmas_tools.offline.kernel_confinement import obstacle
from setcmas_tools.submissions.student import Student
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submitted_files import files_near

_NOT_TRIED = 'not tried in the sandbox of `setcmas grade`, which may refuse it: '


def submission_of(script: Path) -> Submission:
    """Return what a student would submit with a script: also the files in its folder.

    Raises:
        SetcmasError: A module in the folder is too large.
        OSError: A file cannot be read.
    """
    files = files_near(script, with_helpers(script))
    return Submission(script.name, Student(script.name), script.name, files)


def trial(
    submission: Submission, rubric: Rubric, call_timeout: float, own: Marks
) -> tuple[str, bool]:
    """Return note and `is_safe` of a `Check`.

    Args:
        submission: The script or notebook, with the files near it.
        rubric: The rubric.
        call_timeout: As of `Times`, in s.
        own: Its marks outside the sandbox.
    """
    if reason := obstacle():
        return _NOT_TRIED + reason, True
    with TemporaryDirectory(prefix='setcmas_', ignore_cleanup_errors=True) as folder:
        times = Times(call_timeout)
        grader = Grader(rubric, times, confined=True, folder=Path(folder))
        try:
            with sandbox(Path(folder), confined=True) as host:
                run = SandboxRunner(
                    host, submission.script, submission.files, times, rubric.function
                )
                marks = grader.marks(submission, lambda _: run)
        except MachineError as error:
            return f'{_NOT_TRIED}{error}', True
    return _compared(own, marks)


def _compared(own: Marks, graded: Marks) -> tuple[str, bool]:
    is_safe = graded.score >= own.score
    failure = _failure(graded)
    if failure and not _failure(own):
        first = failure.message.partition('\n')[0]
        return f'`setcmas grade` refuses: {first}', False
    if graded.score == own.score:
        return '', True
    points = f'{points_text(graded.score)} of {points_text(graded.max_score)} points'
    why = 'each robot has its own process and random numbers there'
    return f'`setcmas grade` gives {points}: {why}', is_safe


def _failure(marks: Marks) -> Failure | None:
    failures = (marks.failure, *(one.failure for one in marks.scenarios))
    return next((one for one in failures if one), None)
