"""Process that grades submissions one after the other, each in the box that it keeps."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from setcmas_ctrl.scripts.messages import summarise
from setcmas_tools.grading.marking import mark, unmarked
from setcmas_tools.grading.marks import Failure, LawRunner, Marks
from setcmas_tools.grading.rubric import Rubric
from setcmas_tools.grading.sandbox.box import Box
from setcmas_tools.grading.sandbox.held import Times
from setcmas_tools.grading.sandbox.runner import BoxRunner
from setcmas_tools.grading.submissions.found import Submission
from setcmas_tools.offline.parent import end_with_parent

Runners = Callable[[Path], LawRunner]
"""Returns what runs scenarios with a script."""


@dataclass(frozen=True)
class Grader:
    """What grades submissions.

    Attributes:
        rubric: What they are marked by.
        times: How long a run may take.
        confined: Whether they are kept in by the kernel.
        folder: Where processes have folders of their own.
    """

    rubric: Rubric
    times: Times
    confined: bool
    folder: Path

    def marks(self, submission: Submission, runs: Runners) -> Marks:
        """Return the marks of a submission.

        Args:
            submission: The submission.
            runs: Returns what runs scenarios with its script.

        Raises:
            SetcmasError: The rubric's solution fails, or a file of the rubric cannot be used.
        """
        rubric, name, student = self.rubric, submission.name, submission.student
        if submission.problem:
            return unmarked(rubric, name, student, Failure(submission.problem))
        with TemporaryDirectory(dir=self.folder) as folder:
            script = Path(folder, submission.script)
            for path, content in submission.files.items():
                Path(folder, path).parent.mkdir(parents=True, exist_ok=True)
                Path(folder, path).write_bytes(content)
            return mark(rubric, runs(script), name, student, script)


_own: tuple[Grader, Box]


def begin(grader: Grader) -> None:
    """Prepare this process to grade; it ends with the one that started it."""
    global _own
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one that started it
    _own = grader, Box(grader.folder, grader.confined)


def graded(submission: Submission) -> Marks:
    """Return the marks of a submission, in a process that has begun.

    Raises:
        SetcmasError: The rubric's solution fails, or a file of the rubric cannot be used.
    """
    grader, box = _own
    times, function = grader.times, grader.rubric.function
    run = BoxRunner(box, submission.script, submission.files, times, function)
    try:
        return grader.marks(submission, lambda _: run)
    except (OSError, ValueError) as error:  # such as files whose names do not go together
        failure = Failure(f'it cannot be graded: {summarise(error)}')
        return unmarked(grader.rubric, submission.name, submission.student, failure)
