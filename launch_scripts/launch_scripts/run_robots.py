"""The robots of a recorded run, from start to end of their processes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from tqdm import tqdm

from launch_scripts.experiment import RecordedExperiment
from launch_scripts.processes import PAGE, SimulatedRun, outcome_of
from launch_scripts.supervisor import Child, ChildDiedError, StoppedError, Supervisor
from launch_scripts.terminal import Stream, write_line
from setcmas_simu.reports import Ready
from setcmas_tools.run.run_folder import RunFolder
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState

STOPPED = 130
"""Exit status after Ctrl-C, as in shells."""

_START_TIMEOUT_S = 60.0  # fifty robots take half of it on a busy machine
_PAGE_TIMEOUT_S = 15.0
_ROUNDING_S = 1e-9

Robots = RecordedExperiment | SimulatedRun


def run_robots(
    verb: str,
    supervisor: Supervisor,
    start: Callable[[], Robots],
    duration: float,
    folder: RunFolder,
    info: RunInfo,
    views: Sequence[tuple[str, list[str]]],
) -> tuple[int, Outcome | None]:
    """Run the robots, from start to end of their processes.

    `start` starts those of the robots; `duration` is in s, from the first command.

    Returns:
        The exit status, and the outcome; None if the run has not begun.
    """
    folder.create(info)  # not earlier: Ctrl-C would leave it behind

    def write(line: str, stream: Stream) -> None:
        with tqdm.external_write_mode(file=supervisor.stderr):
            write_line(line, stream)

    supervisor.write = write
    pages = [supervisor.start(name, command, needed=False) for name, command in views]
    pages = [page for page in pages if page.name == PAGE]
    run: Robots | None = None
    try:
        _wait_for(pages, supervisor)
        run = start()
        deadline = time.monotonic() + _START_TIMEOUT_S
        supervisor.run(lambda: run.started or time.monotonic() > deadline, run.tick)
        if not run.started:
            supervisor.warn(
                f'setcmas {verb}: the robots did not start within {_START_TIMEOUT_S:g} s; '
                f'{run.missing}'
            )
            return 1, Outcome(RunState.NOT_STARTED, detail=run.missing)
        _show_progress(supervisor, duration, run)
        return _finish(verb, supervisor, run, folder)
    except StoppedError:
        if run and run.started:
            return STOPPED, Outcome(RunState.STOPPED)
        if run:
            run.recorder.shown = False  # it would report a bag that is then removed
        return STOPPED, None
    except ChildDiedError as death:
        reason = str(death)
        if reason:
            supervisor.warn(f'setcmas {verb}: {reason}; the others are stopped')
            return death.exit_status, Outcome(RunState.DIED, detail=reason)
        if run:
            run.recorder.shown = False
        return death.exit_status, None
    finally:
        if run:
            run.stop()


def _finish(
    verb: str, supervisor: Supervisor, run: Robots, folder: RunFolder
) -> tuple[int, Outcome]:
    """Stop the control laws; return exit status and outcome."""
    trouble, is_stuck = run.trouble, run.is_stuck
    run.finish()
    folder.failures = list(run.failures)
    outcome = outcome_of(run.failed)
    if is_stuck:
        outcome = replace(outcome, state=RunState.NOT_FINISHED)
    if trouble:
        supervisor.warn(f'setcmas {verb}: {trouble}')
        return 1, replace(outcome, detail=trouble)
    if run.status:
        return run.status, replace(outcome, state=RunState.FAILED)
    return 0, outcome


def _wait_for(pages: Sequence[Child], supervisor: Supervisor) -> None:
    """Wait until pages can show the run from its start, with a time-out."""
    deadline = time.monotonic() + _PAGE_TIMEOUT_S
    supervisor.run(
        lambda: (
            all(page.reported(Ready) or not page.running() for page in pages)
            or time.monotonic() > deadline
        )
    )


def _show_progress(supervisor: Supervisor, duration: float, run: Robots) -> None:
    begin = time.monotonic()

    def elapsed() -> float:
        return run.elapsed(time.monotonic() - begin)

    form = '{desc}: {percentage:3.0f}%|{bar}| {n:.0f}/{total:.0f} s'
    with tqdm(
        total=duration, desc='running', bar_format=form, disable=None, file=supervisor.stderr
    ) as bar:

        def advance() -> None:
            run.tick()
            bar.set_description_str('paused' if run.paused else 'running', refresh=False)
            bar.update(min(duration, elapsed()) - bar.n)

        supervisor.run(
            until=lambda: elapsed() >= duration - _ROUNDING_S or run.is_stuck, on_tick=advance
        )
        bar.update(0 if run.is_stuck else duration - bar.n)
