"""Grading of a class: workers, stored marks, and their order."""

from __future__ import annotations

import errno
import hashlib
import logging
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing.util import Finalize
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from types import ModuleType

import msgspec
from tqdm import tqdm

from setcmas_ctrl.scripts.loader import ALGORITHMS, EXERCISES
from setcmas_ctrl.scripts.machine_paths import without_paths
from setcmas_ctrl.scripts.script_errors import safe_text, summarise
from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.grade_options import GradeOptions
from setcmas_tools.grade.marking import mark, unmarked
from setcmas_tools.grade.marks import Failure, LawRunner, Marks, ScenarioRun
from setcmas_tools.grade.rubric import Rubric
from setcmas_tools.grade.rubric_scenarios import MarkedScenario
from setcmas_tools.grade.sandbox import SandboxRunner, Times, sandbox
from setcmas_tools.offline.child_channel import MachineError
from setcmas_tools.offline.fork_server import end_with_parent
from setcmas_tools.offline.host import Host
from setcmas_tools.offline.kernel_confinement import obstacle
from setcmas_tools.submissions.likeness import Print, fingerprint, likenesses
from setcmas_tools.submissions.notebook import in_cells
from setcmas_tools.submissions.submissions import Submission
from setcmas_tools.submissions.submissions import find_submissions as find_submissions

Runners = Callable[[Path], LawRunner]
"""Returns the runner of scenarios with a script."""


@dataclass(frozen=True)
class Grader:
    """Grades submissions; `folder` is the parent of the processes' own folders."""

    rubric: Rubric
    times: Times
    confined: bool
    folder: Path

    def marks(self, submission: Submission, runs: Runners) -> Marks:
        """Return the marks of a submission.

        Raises:
            SetcmasError: The rubric's solution fails, a file of the rubric cannot be used, or the
                machine ends a run (MachineError).
        """
        marks = replace(self._marks(submission, runs), file=submission.file)
        return marks.with_messages(without_paths)

    def _marks(self, submission: Submission, runs: Runners) -> Marks:
        rubric, name, student = self.rubric, submission.name, submission.student
        if submission.problem:
            return unmarked(rubric, name, student, Failure(submission.problem))
        with submission.unpacked(self.folder) as script:
            return mark(rubric, named_cells(runs(script), submission), name, student, script)


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


_own: tuple[Grader, Host]


def begin(grader: Grader) -> None:
    """Prepare this process for grading; it ends with its parent."""
    global _own
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the one that started it
    _own = grader, sandbox(grader.folder, grader.confined)
    Finalize(None, _own[1].close, exitpriority=1)  # atexit is not for such processes


def graded(submission: Submission) -> Marks:
    """Return the marks of a submission, in a prepared process; raises as `Grader.marks`."""
    grader, host = _own
    times, function = grader.times, grader.rubric.function
    run = SandboxRunner(host, submission.script, submission.files, times, function)
    try:
        return grader.marks(submission, lambda _: run)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno not in _OF_FILE_NAMES:
            raise MachineError from error
        failure = Failure(without_paths(f'it cannot be graded: {summarise(error)}'))
        return unmarked(grader.rubric, submission.name, submission.student, failure)


_OF_FILE_NAMES = {errno.EEXIST, errno.ENOTDIR, errno.EISDIR, errno.ENAMETOOLONG, errno.EINVAL}
"""Errors that conflicting file names cause; others, such as ENOSPC, are the machine's."""

KEPT = 'marks'
"""Folder with the marks of submissions."""

_SANDBOX = 5
"""Version of the sandbox; in earlier ones scripts could leave it, or robots could communicate."""


class KeptMarks:
    """A folder with a file of marks for each graded submission."""

    def __init__(self, folder: Path, grader: Grader) -> None:
        """Open the folder in that of the grades; marks of another grader do not count."""
        self._folder = folder / KEPT
        self._folder.mkdir(parents=True, exist_ok=True)
        self._grader = _digest(
            repr((__version__, _SANDBOX, grader.times, grader.confined)).encode(),
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
        part = self._folder / f'{digest}.part'
        part.write_bytes(msgspec.json.encode(kept))
        part.replace(part.with_suffix('.json'))
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


_MOST_NAMES = 5
_logger = logging.getLogger(__name__)


def grade(
    submissions: Sequence[Submission],
    rubric: Rubric,
    folder: Path,
    options: GradeOptions,
) -> list[Marks]:
    """Grade submissions that are not graded yet; return the marks of all.

    Args:
        submissions: The submissions.
        rubric: Rubric for the marks.
        folder: Folder of the grades.
        options: Options of the grading.

    Raises:
        SetcmasError: There is no sandbox, the rubric's solution fails, or the machine has kept
            submissions from running; the marks of all others are stored.
        OSError: The marks cannot be written.
    """
    if not hasattr(os, 'fork'):
        raise SetcmasError('grading works on Linux and macOS; on Windows, use WSL 2')
    reason = '' if options.trust else obstacle()
    if reason:
        raise SetcmasError(
            f'no sandbox: {reason}; --trust grades without sandbox, where submissions can '
            'do whatever you can'
        )
    for scenario in rubric.scenarios:
        rubric.solution_run(scenario)  # report its errors first
    with TemporaryDirectory(prefix='setcmas_', ignore_cleanup_errors=True) as place:
        times = Times(options.call_timeout, options.timeout)
        grader = Grader(rubric, times, not options.trust, Path(place))
        kept = KeptMarks(folder, grader)
        earlier = () if options.overwrite else submissions
        marks = {one.name: found for one in earlier if (found := kept.found(one))}
        left = [one for one in submissions if one.name not in marks]
        bar = tqdm(desc='grading', total=len(submissions), initial=len(marks), disable=None)
        with bar:
            for submission, made in _made(left, grader, options.jobs):
                if made:
                    marks[submission.name] = kept.keep(submission, made)
                bar.update()
    kept.drop_others(submissions)
    _check_all_marked(marks, submissions)
    like = likenesses(*_prints(submissions, rubric))
    return [replace(marks[one.name], similar=tuple(like[one.name])) for one in submissions]


def _check_all_marked(marks: Mapping[str, Marks], submissions: Sequence[Submission]) -> None:
    """Check that all are marked: zero points in a table would look like the students' fault.

    Raises:
        SetcmasError: Some are not.
    """
    names = [safe_text(str, one.name) for one in submissions if one.name not in marks]
    if names:
        more = f' and {len(names) - _MOST_NAMES} more' if len(names) > _MOST_NAMES else ''
        raise SetcmasError(
            f'not marked: {", ".join(names[:_MOST_NAMES])}{more}. This computer ran out of '
            'memory, disk or processes, or setcmas failed; repeat the command, with fewer --jobs, '
            'to grade the rest and write the tables'
        )


def _made(
    submissions: Sequence[Submission], grader: Grader, jobs: int
) -> Iterator[tuple[Submission, Marks | None]]:
    """Yield the marks of submissions as they finish; None for what the machine cannot run.

    If a grading process dies, its submissions are graded again, one at a time.
    """
    left = list(submissions)
    while left:
        done = []
        try:
            with _pool(grader, min(jobs, len(left))) as pool:
                with _without_main():
                    waiting = {pool.submit(graded, one): one for one in left}
                for future in as_completed(waiting):
                    one = waiting[future]
                    made = _result(future, one)
                    done.append(one)
                    yield one, made
        except BrokenProcessPool:
            left = [one for one in left if one not in done]
            if jobs == 1:
                yield left.pop(0), None
            jobs = 1
        else:
            return


def _result(future: Future[Marks], submission: Submission) -> Marks | None:
    """Return marks; None if an error is not the submission's, which does not stop the others."""
    try:
        return future.result()
    except MachineError:
        return None
    except (SetcmasError, BrokenProcessPool):
        raise
    except Exception:
        _logger.exception('internal error while grading %r', submission.name)
        return None


@contextmanager
def _pool(grader: Grader, jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of grading processes, and end all of them if the grading is stopped."""
    context = multiprocessing.get_context('spawn')
    pool = ProcessPoolExecutor(jobs, context, begin, (grader,))
    try:
        yield pool
    except BaseException:
        for process in multiprocessing.active_children():
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _without_main() -> Iterator[None]:
    """Start processes without the main module: it may be read from stdin, or grade again."""
    main, sys.modules['__main__'] = sys.modules['__main__'], ModuleType('__main__')
    try:
        yield
    finally:
        sys.modules['__main__'] = main


def _prints(
    submissions: Sequence[Submission], rubric: Rubric
) -> tuple[dict[str, Print], dict[str, Print]]:
    """Return fingerprints of submissions and built-in laws."""
    given: Print = frozenset()
    if rubric.exercise:
        given = fingerprint([EXERCISES.file(rubric.exercise).read_bytes()])
    own = {one.name: fingerprint(_sources(one), given) for one in submissions}
    shipped = (name for name, plugin in ALGORITHMS.plugins().items() if plugin.built_in)
    laws = {ALGORITHMS.file(name): f'the built-in law {name}' for name in shipped}
    if rubric.solution:
        laws = {rubric.solution: 'the solution', **laws}
    known = {name: fingerprint([file.read_bytes()], given) for file, name in laws.items()}
    return own, known


def _sources(submission: Submission) -> list[bytes]:
    return [content for name, content in submission.files.items() if name.endswith('.py')]
