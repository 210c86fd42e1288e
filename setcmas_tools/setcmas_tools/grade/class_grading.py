"""Grading of a class: what was handed in, its marks, and the marks that are kept."""

from __future__ import annotations

import ctypes
import hashlib
import logging
import signal
import sys
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath

import msgspec
from tqdm import tqdm

from setcmas_ctrl.laws.script_loader import ALGORITHMS, EXERCISES
from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.limited_file import written_whole
from setcmas_tools.grade.mark_pictures import picture_url
from setcmas_tools.grade.marking import mark, unmarked
from setcmas_tools.grade.marks import Failure, LawRunner, Marks, ScenarioRun
from setcmas_tools.grade.rubric import MarkedScenario, Rubric
from setcmas_tools.grade.submission_run import SandboxRunner, Times
from setcmas_tools.submissions.confined_program import READ
from setcmas_tools.submissions.confinement import obstacle
from setcmas_tools.submissions.likeness import Print, fingerprint, likenesses
from setcmas_tools.submissions.machine_paths import without_paths
from setcmas_tools.submissions.notebook import in_cells
from setcmas_tools.submissions.sandbox import ConfinedProcess, NoProcessError, ProcessEndedError
from setcmas_tools.submissions.submissions import Packed, Submission, find_submissions

_DPI = 80  # of the pictures on pages
_READ_S = 60.0
_MOST_READ = 1 << 26  # bytes of an unpacked submission, with its fingerprint


def check_sandbox() -> None:
    """Check that submissions can be confined.

    Raises:
        SetcmasError: They cannot; the message says what to do.
    """
    if reason := obstacle():
        raise SetcmasError(
            f'no sandbox: {reason}; or add --trust to grade without it: submissions can then '
            'do whatever you can'
        )


def read_class(place: Path, rubric: Rubric, jobs: int, is_confined: bool) -> list[Submission]:
    """Return the submissions in a folder or a zip file, each unpacked in the sandbox.

    Raises:
        SetcmasError: There are none, or the machine cannot run more processes.
    """
    exercise = EXERCISES.file(rubric.exercise).read_bytes() if rubric.exercise else b''

    def read(packed: Sequence[Packed]) -> list[Submission]:
        with ThreadPoolExecutor(jobs) as pool:
            return list(pool.map(partial(read_apart, is_confined=is_confined), packed))

    return find_submissions(place, rubric.function, exercise, read)


def read_apart(packed: Packed, is_confined: bool = True) -> Submission:
    """Unpack a submission in a process of its own, which its files can harm alone.

    Raises:
        NoProcessError: The process does not start.
    """
    name = packed.files[-1].top
    late = f'it takes longer than {_READ_S:g} s to unpack'
    try:
        with ConfinedProcess(is_confined, READ + msgspec.msgpack.encode(packed)) as process:
            answer = process.answer(b'', _READ_S, late, _MOST_READ)
        read = msgspec.msgpack.decode(answer, type=Submission)
        if not _is_of(read, packed):
            raise ValueError(read.name)
    except ProcessEndedError as error:
        return Submission(name, packed.student, problem=f'it cannot be unpacked: {error}')
    except (msgspec.MsgspecError, RecursionError, ValueError):
        return Submission(name, packed.student, problem='it cannot be unpacked')
    return read


def _is_of(read: Submission, packed: Packed) -> bool:
    """Return whether what a confined process has read may be a submission's."""
    names = [PurePosixPath(name) for name in read.files]
    return (
        read.student == packed.student
        and bool(read.problem or read.script in read.files)
        and all(name.parts and not name.is_absolute() and '..' not in name.parts for name in names)
    )


@dataclass(frozen=True)
class Grader:
    """Grades submissions, each run in a process of its own."""

    rubric: Rubric
    times: Times = field(default_factory=Times)
    is_confined: bool = True

    def marks(self, submission: Submission) -> Marks:
        """Return the marks of a submission.

        Raises:
            SetcmasError: The rubric's solution fails, a file of the rubric cannot be used, or the
                machine ends a run (NoProcessError).
        """
        rubric, name, student = self.rubric, submission.name, submission.student
        if submission.problem:
            marks = unmarked(rubric, name, student, Failure(submission.problem))
        else:
            run = SandboxRunner(
                submission.script, submission.files, self.times, rubric.function, self.is_confined
            )
            shown = named_cells(run, submission)
            marks = mark(rubric, shown, name, student, submission.is_unfilled)
        marks = replace(marks, file=submission.file).with_messages(without_paths)
        drawn = (
            replace(one, picture=picture_url(replace(marks, scenarios=(one,)), _DPI))
            for one in marks.scenarios
        )
        return replace(marks, scenarios=tuple(drawn))

    def tried(self, submission: Submission) -> tuple[str, Marks | None]:
        """Return the name of a submission and its marks; None if it is not why there are none.

        Raises:
            SetcmasError: As `marks`, unless the machine ends a run.
        """
        try:
            return submission.name, self.marks(submission)
        except NoProcessError:
            return submission.name, None
        except SetcmasError:
            raise
        except Exception:  # it does not stop the others
            _logger.exception('internal error while grading %r', submission.name)
            return submission.name, None


def named_cells(run: LawRunner, submission: Submission) -> LawRunner:
    """Return a runner whose failures name the cells of a notebook, if it is one."""
    notebook, name = submission.notebook, PurePosixPath(submission.file).name
    if not notebook:
        return run

    def run_notebook(scenario: MarkedScenario) -> ScenarioRun:
        done = run(scenario)
        failure = done.failure
        if not failure:
            return done
        shown = replace(failure, message=in_cells(failure.message, name, notebook))
        if failure.line and failure.script == submission.script:
            cell, line = notebook.place(failure.line)
            shown = shown.at(f'{name}, cell {cell}', line, notebook.cells[cell - 1])
        return replace(done, failure=shown)

    return run_notebook


KEPT = 'marks'
"""Folder with the marks of submissions."""

_SANDBOX = 6
"""Version of the sandbox; in earlier ones scripts could leave it, or robots could communicate."""


class KeptMarks:
    """A folder with a file of marks for each graded submission."""

    def __init__(self, folder: Path, grader: Grader) -> None:
        """Open the folder in that of the grades; marks of another grader do not count."""
        self._folder = folder / KEPT
        self._folder.mkdir(parents=True, exist_ok=True)
        self._grader = _digest(
            repr((__version__, _SANDBOX, grader.times, grader.is_confined)).encode(),
            *(part for file in grader.rubric.files for part in (file.name.encode(), _read(file))),
        )

    def digest(self, submission: Submission) -> str:
        """Return a digest that is equal for submissions with equal marks."""
        parts = [self._grader.encode(), repr((submission.name, submission.script)).encode()]
        parts += [submission.problem.encode()]
        for name, content in sorted(submission.files.items()):
            parts += [name.encode(errors='surrogateescape'), content]
        return _digest(*parts)

    def found(self, submission: Submission) -> Marks | None:
        """Return the stored marks of a submission; None if it was not graded."""
        digest = self.digest(submission)
        try:
            marks = msgspec.json.decode((self._folder / f'{digest}.json').read_bytes(), type=Marks)
        except (OSError, msgspec.MsgspecError):
            return None
        return marks if marks.digest == digest else None

    def keep(self, submission: Submission, marks: Marks) -> Marks:
        """Write the marks of a submission, whole or not at all; return them with their digest."""
        digest = self.digest(submission)
        kept = replace(marks, digest=digest)
        with written_whole(self._folder / f'{digest}.json') as file:
            file.write(msgspec.json.encode(kept).decode())
        return kept

    def drop_others(self, submissions: Iterable[Submission]) -> None:
        """Remove the marks of all other submissions."""
        wanted = {self.digest(one) for one in submissions}
        for file in self._folder.iterdir():
            if file.stem not in wanted and file.suffix in ('.json', '.part'):
                file.unlink()


def _read(file: Path) -> bytes:
    return file.read_bytes() if file.is_file() else b''


def _digest(*parts: bytes) -> str:
    whole = hashlib.sha256()
    for part in parts:
        whole.update(b'%d:' % len(part) + part)
    return whole.hexdigest()


_NOT_RUN = (
    'this computer ran out of memory, disk or processes, or setcmas failed; repeat the command, '
    'with fewer --jobs'
)
_logger = logging.getLogger(__name__)


def grade(
    submissions: Sequence[Submission],
    grader: Grader,
    folder: Path,
    jobs: int = 1,
    again: bool = False,
) -> list[Marks]:
    """Grade submissions that are not graded yet; return the marks of all.

    The marks are kept in the folder of the grades; `again` grades those that are there, too.

    A submission that the machine has kept from running, or that has made setcmas fail, is not
    marked; the next grading tries again.

    Raises:
        SetcmasError: The rubric's solution fails.
        OSError: The marks cannot be written.
    """
    rubric = grader.rubric
    for scenario in rubric.scenarios:
        rubric.solution_run(scenario)  # report its errors first
    kept = KeptMarks(folder, grader)
    earlier = () if again else submissions
    marks = {one.name: found for one in earlier if (found := kept.found(one))}
    by_name = {one.name: one for one in submissions}
    left = [one for one in submissions if one.name not in marks]
    with tqdm(
        desc='grading', total=len(submissions), initial=len(marks), disable=None
    ) as progress:
        for name, made in _made(left, grader, jobs):
            submission = by_name[name]
            marks[name] = (
                kept.keep(submission, made)
                if made
                else unmarked(rubric, name, submission.student, Failure(_NOT_RUN))
            )
            progress.update()
    kept.drop_others(submissions)
    like = likenesses(*_prints(submissions, rubric))
    return [replace(marks[one.name], similar=tuple(like[one.name])) for one in submissions]


def _made(
    submissions: Sequence[Submission], grader: Grader, jobs: int
) -> Iterator[tuple[str, Marks | None]]:
    """Yield names and marks of submissions as they finish; None for what the machine cannot run.

    If a grading process dies, what is left is graded again, one submission at a time.
    """
    left = {one.name: one for one in submissions}
    if jobs > 1:
        try:
            for name, made in _graded(submissions, grader, jobs):
                del left[name]
                yield name, made
        except BrokenProcessPool:
            _logger.warning('a grading process has died: the rest is graded one at a time')
    for one in left.values():
        try:
            # Two workers, for joblib makes one of this process, which would die with it.
            yield from _graded([one], grader, jobs=2)
        except BrokenProcessPool:
            yield one.name, None


def _graded(
    submissions: Sequence[Submission], grader: Grader, jobs: int
) -> Iterator[tuple[str, Marks | None]]:
    """Yield what `Grader.tried` returns, from several processes.

    Raises:
        BrokenProcessPool: One of them has died.
    """
    with needs('grade'):
        import joblib
    parallel = joblib.Parallel(
        jobs, 'loky', return_as='generator_unordered', initializer=_end_with_parent
    )
    yield from parallel(joblib.delayed(grader.tried)(one) for one in submissions)


_PR_SET_PDEATHSIG = 1


def _end_with_parent() -> None:
    """Let a grading process end when the one that has started it is killed."""
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _prints(
    submissions: Sequence[Submission], rubric: Rubric
) -> tuple[dict[str, Print], dict[str, Print]]:
    """Return fingerprints of submissions and built-in laws."""
    given: Print = frozenset()
    if rubric.exercise:
        given = fingerprint([EXERCISES.file(rubric.exercise).read_bytes()])
    own = {one.name: one.print - given for one in submissions}
    shipped = (name for name, plugin in ALGORITHMS.plugins().items() if plugin.built_in)
    laws = {ALGORITHMS.file(name): f'the built-in law {name}' for name in shipped}
    if rubric.solution:
        laws = {rubric.solution: 'the solution', **laws}
    known = {name: fingerprint([file.read_bytes()], given) for file, name in laws.items()}
    return own, known
