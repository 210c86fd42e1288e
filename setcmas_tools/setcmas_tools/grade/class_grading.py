"""Grading of a class: what was handed in, its marks, and the marks that are kept."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
from tqdm import tqdm

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.limited_file import written_whole
from setcmas_simu.reports import end_with_parent
from setcmas_tools.grade.mark_pictures import picture_url
from setcmas_tools.grade.mark_records import Marks
from setcmas_tools.grade.marking import mark, unmarked
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.grade.submission_run import SandboxRunner, Times
from setcmas_tools.submissions.likeness import Print, Similar, fingerprint, likenesses
from setcmas_tools.submissions.sandbox import obstacle
from setcmas_tools.submissions.submissions import Submission, read_submissions

_DPI = 80  # of the pictures on pages


def read_class(place: Path, rubric: Rubric, is_confined: bool) -> list[Submission]:
    """Return the submissions in a folder or a zip file, sorted by students' names.

    Raises:
        SetcmasError: There are none, or they cannot be confined; the message says what to do.
    """
    if is_confined and (reason := obstacle()):
        raise SetcmasError(
            f'no sandbox: {reason}; or add --trust to grade without it: submissions can then '
            'do whatever you can'
        )
    exercise = EXERCISES.file(rubric.exercise).read_bytes() if rubric.exercise else b''
    return read_submissions(place, rubric.function, exercise)


@dataclass(frozen=True)
class Grader:
    """Grades submissions, each run in a process of its own."""

    rubric: Rubric
    times: Times = field(default_factory=Times)
    is_confined: bool = True

    def marks(self, submission: Submission) -> Marks:
        """Return the marks of a submission, with pictures.

        Raises:
            SetcmasError: The rubric's solution fails, a file of the rubric cannot be used, or the
                machine ends a run (NoProcessError).
        """
        run = SandboxRunner(submission, self.times, self.rubric.function, self.is_confined)
        marks = mark(self.rubric, run, submission)
        drawn = (replace(one, picture=picture_url([one], _DPI)) for one in marks.scenarios)
        return replace(marks, scenarios=tuple(drawn))

    def tried(self, submission: Submission) -> tuple[Submission, Marks | None]:
        """Return a submission and its marks; None if setcmas itself fails, raise as `marks`."""
        try:
            return submission, self.marks(submission)
        except SetcmasError:
            raise
        except Exception:  # it does not stop the others
            _logger.exception('internal error while grading %r', submission.name)
            return submission, None


KEPT = 'marks'
"""Folder with the marks of submissions."""


class KeptMarks:
    """A folder with a file of marks for each graded submission."""

    def __init__(self, folder: Path, grader: Grader) -> None:
        """Open the folder in that of the grades; marks of another grader do not count."""
        self._folder = folder / KEPT
        self._folder.mkdir(parents=True, exist_ok=True)
        files = [(one.name, one.is_file() and one.read_bytes()) for one in grader.rubric.files]
        self._grader = _digest((__version__, grader.times, grader.is_confined, files))

    def found(self, submission: Submission) -> Marks | None:
        """Return the stored marks of a submission; None if it was not graded as it is."""
        try:
            return msgspec.json.decode(self._file(submission).read_bytes(), type=Marks)
        except (OSError, msgspec.MsgspecError):
            return None

    def keep(self, submission: Submission, marks: Marks) -> None:
        """Write the marks of a submission, whole or not at all."""
        with written_whole(self._file(submission)) as file:
            file.write(msgspec.json.encode(marks).decode())

    def _file(self, submission: Submission) -> Path:
        """Return the file for the marks of a submission, named after all that they depend on."""
        files = sorted(submission.files.items())
        own = (submission.name, submission.script, submission.problem, files)
        return self._folder / f'{_digest((self._grader, own))}.json'


def _digest(content: object) -> str:
    return hashlib.sha256(msgspec.msgpack.encode(content)).hexdigest()


NOT_RUN = 'setcmas failed, and has printed why; the same command tries again'
"""Of a submission that could not be graded, for no reason of its own."""

_logger = logging.getLogger(__name__)


def grade(
    submissions: Sequence[Submission],
    grader: Grader,
    folder: Path,
    jobs: int | None = 1,
) -> list[Marks]:
    """Grade submissions that are not graded yet; return the marks of all.

    The marks are kept in the folder of the grades.

    A submission that has made setcmas fail is not marked (NOT_RUN); the next grading tries again.

    Raises:
        SetcmasError: The rubric's solution fails, or the machine has ended a process.
        OSError: The marks cannot be written.
    """
    rubric = grader.rubric
    for scenario in rubric.scenarios:
        rubric.solution_run(scenario)  # report its errors first
    kept = KeptMarks(folder, grader)
    marks = {one.name: found for one in submissions if (found := kept.found(one))}
    left = [one for one in submissions if one.name not in marks]
    with tqdm(
        desc='grading', total=len(submissions), initial=len(marks), disable=None
    ) as progress:
        for one, made in _graded(left, grader, jobs):
            if made:
                kept.keep(one, made)
            marks[one.name] = made or unmarked(rubric, one, NOT_RUN)
            progress.update()
    like = _likenesses(submissions, rubric)
    return [replace(marks[one.name], similar=tuple(like[one.name])) for one in submissions]


def _graded(
    submissions: Sequence[Submission], grader: Grader, jobs: int | None
) -> Iterator[tuple[Submission, Marks | None]]:
    """Yield what `Grader.tried` returns, from several processes."""
    with needs('grade'):
        import joblib
    parallel = joblib.Parallel(
        jobs or -1, return_as='generator_unordered', initializer=end_with_parent, initargs=(True,)
    )
    try:
        yield from parallel(joblib.delayed(grader.tried)(one) for one in submissions)
    except BrokenProcessPool as error:
        raise SetcmasError(
            'a process that graded was killed, perhaps for lack of memory; run the same command '
            'again, with fewer --jobs'
        ) from error


def _likenesses(submissions: Sequence[Submission], rubric: Rubric) -> dict[str, list[Similar]]:
    """Return what each submission is like: others, the solution and built-in laws."""
    given: Print = frozenset()
    if rubric.exercise:
        given = fingerprint([EXERCISES.file(rubric.exercise).read_bytes()])
    own = {one.name: one.print - given for one in submissions}
    shipped = (name for name, plugin in ALGORITHMS.plugins().items() if plugin.built_in)
    laws = {ALGORITHMS.file(name): f'the built-in law {name}' for name in shipped}
    if rubric.solution:
        laws = {rubric.solution: 'the solution', **laws}
    known = {name: fingerprint([file.read_bytes()], given) for file, name in laws.items()}
    return likenesses(own, known)
