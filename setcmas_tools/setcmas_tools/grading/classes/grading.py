"""Grading of a class: what is not done yet, several submissions at a time."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from tqdm import tqdm

from setcmas_ctrl.scripts.loader import ALGORITHMS, EXERCISES
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grading.classes.kept import KeptMarks
from setcmas_tools.grading.classes.options import GradeOptions
from setcmas_tools.grading.classes.worker import Grader, Runners, begin, graded
from setcmas_tools.grading.marking import unmarked
from setcmas_tools.grading.marks import Failure, Marks
from setcmas_tools.grading.rubric import Rubric
from setcmas_tools.grading.sandbox.confinement import obstacle
from setcmas_tools.grading.sandbox.held import Times
from setcmas_tools.grading.submissions.found import Submission
from setcmas_tools.grading.submissions.likeness import Print, fingerprint, likenesses

_BROKEN = Failure('the process that graded it ended; is there enough memory?')


def grade(
    submissions: Sequence[Submission],
    rubric: Rubric,
    folder: Path,
    options: GradeOptions,
    in_lab: Runners | None = None,
) -> list[Marks]:
    """Grade submissions, but for those that are graded already; returns the marks of all.

    Args:
        submissions: The submissions.
        rubric: What they are marked by.
        folder: Keeps the marks of each.
        options: How they are graded.
        in_lab: Runs them one after the other in the emulated lab; None is offline, in a sandbox.

    Raises:
        SetcmasError: There is no sandbox, or the rubric's solution fails.
        OSError: The marks cannot be written.
    """
    if not hasattr(os, 'fork'):
        raise SetcmasError('submissions are graded on Linux and macOS; on Windows, use WSL 2')
    reason = '' if options.trust else obstacle()
    if reason:
        raise SetcmasError(
            f'there is no sandbox here: {reason}; --trust grades without, which lets submissions '
            'do whatever you can'
        )
    for scenario in rubric.scenarios:
        rubric.solution_run(scenario)  # what is wrong with it is told before all else
    with TemporaryDirectory(prefix='setcmas_', ignore_cleanup_errors=True) as place:
        times = Times(options.call_timeout, options.timeout)
        grader = Grader(rubric, times, not options.trust, Path(place))
        kept = KeptMarks(folder, grader, in_lab is not None)
        earlier = () if options.overwrite else submissions
        marks = {one.name: found for one in earlier if (found := kept.found(one))}
        left = [one for one in submissions if one.name not in marks]
        bar = tqdm(desc='grading', total=len(submissions), initial=len(marks), disable=None)
        with bar:
            some = _made_in_lab(left, grader, in_lab) if in_lab else None
            for submission, made in some or _made(left, grader, options.jobs):
                marks[submission.name] = kept.keep(submission, made)
                bar.update()
    kept.drop_others(submissions)
    like = likenesses(*_prints(submissions, rubric))
    return [replace(marks[one.name], similar=tuple(like[one.name])) for one in submissions]


def _made_in_lab(
    submissions: Sequence[Submission], grader: Grader, in_lab: Runners
) -> Iterator[tuple[Submission, Marks]]:
    for one in submissions:
        yield one, grader.marks(one, in_lab)


def _made(
    submissions: Sequence[Submission], grader: Grader, jobs: int
) -> Iterator[tuple[Submission, Marks]]:
    """Yield the marks of submissions as they come.

    If a process that grades dies, submissions are graded once more, one at a time; the first of
    those is then the one that it died of.
    """
    left = list(submissions)
    while left:
        done = []
        try:
            with _pool(grader, min(jobs, len(left))) as pool:
                waiting = {pool.submit(graded, one): one for one in left}
                for future in as_completed(waiting):
                    one = waiting[future]
                    made = _result(future, grader.rubric, one)
                    done.append(one)
                    yield one, made
        except BrokenProcessPool:
            left = [one for one in left if one not in done]
            if jobs == 1:
                first = left.pop(0)
                yield first, unmarked(grader.rubric, first.name, first.student, _BROKEN)
            jobs = 1
        else:
            return


def _result(future: Future[Marks], rubric: Rubric, submission: Submission) -> Marks:
    """Return marks; a mistake of ours about one submission does not stop the others."""
    try:
        return future.result()
    except (SetcmasError, OSError, BrokenProcessPool):
        raise
    except Exception as error:
        failure = Failure(f'setcmas cannot grade it, which is its own mistake: {error!r}')
        return unmarked(rubric, submission.name, submission.student, failure)


@contextmanager
def _pool(grader: Grader, jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes that grade; none of them is left if the grading is stopped."""
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


def _prints(
    submissions: Sequence[Submission], rubric: Rubric
) -> tuple[dict[str, Print], dict[str, Print]]:
    """Return what submissions and shipped laws are compared by."""
    given: Print = frozenset()
    if rubric.exercise:
        given = fingerprint([EXERCISES.file(rubric.exercise).read_bytes()])
    own = {one.name: fingerprint(_sources(one), given) for one in submissions}
    shipped = (name for name, offer in ALGORITHMS.offers().items() if offer.shipped)
    laws = {ALGORITHMS.file(name): f'the shipped law {name}' for name in shipped}
    if rubric.solution:
        laws = {rubric.solution: 'the solution', **laws}
    known = {name: fingerprint([file.read_bytes()], given) for file, name in laws.items()}
    return own, known


def _sources(submission: Submission) -> list[bytes]:
    return [content for name, content in submission.files.items() if name.endswith('.py')]
