"""Runs of a study: each is made in a process of its own, and gets a row."""

from __future__ import annotations

import multiprocessing
import sys
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from setcmas_simu.errors import SetcmasError, needs
from setcmas_tools.measures.metric import Metric
from setcmas_tools.measures.metrics import measure
from setcmas_tools.offline.offline_simulation import checked_steps, silent, simulate
from setcmas_tools.offline.run_progress import size_of
from setcmas_tools.offline.script_process import ScriptEndedError, ScriptProcess, StartError
from setcmas_tools.run.run_info import RunState
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.study.study_columns import numbers_of
from setcmas_tools.study.study_plan import Plan

_LONGEST_MESSAGE = 300

_WARM_UP = 'setcmas_tools.study.warm_up'

Row = dict[str, Any]
"""A row by column: 'run', its outcome, and its metrics."""


def made_rows(plan: Plan, jobs: int | None, timeout: float) -> Iterator[Row]:
    """Make the runs of a study, and yield their rows as they finish, or raise SetcmasError.

    `jobs` run at a time, by default as many as there are cores, each for `timeout` s at most.

    A thread controls the process of each run: joblib's own processes could not be ended
    individually when a script hangs, and one that dies would end all. Within
    `joblib.parallel_config('dask')`, the workers of a cluster take the place of the threads.
    """
    with needs('study'):
        import joblib

    parallel = joblib.Parallel(jobs or -1, prefer='threads', return_as='generator_unordered')
    yield from parallel(
        joblib.delayed(made_row)(run, plan.scenario(run), plan.metrics, timeout)
        for run in range(1, len(plan.runs) + 1)
    )


def made_row(
    number: int, scenario: Scenario, metrics: Mapping[str, Metric], timeout: float
) -> Row:
    """Make a run in a process of its own, for a time in s at most; return its row in any case."""
    from joblib import wrap_non_picklable_objects

    # Each process imports the main module again, which on a cluster imports all of Dask.
    of_main = [name for name in ('distributed',) if name in sys.modules]
    multiprocessing.set_forkserver_preload([*of_main, _WARM_UP])
    try:
        work = wrap_non_picklable_objects((scenario, metrics), keep_wrapper=False)
        size = size_of(checked_steps(scenario) + 1, scenario.nb_robots)
        run = partial(row_of, number, work)
        with ScriptProcess(run, scenario.scripts(), size) as process:
            return process.result(lambda _: None, timeout=timeout)
    except StartError:
        raise  # all other runs would end so
    except SetcmasError as error:
        return _row(number, RunState.NOT_STARTED, message=str(error))
    except ScriptEndedError as error:
        return _row(number, RunState.DIED, str(error.robot or ''), str(error).partition('\n')[0])


def row_of(number: int, work: tuple[Scenario, Mapping[str, Metric]], **_: object) -> Row:
    """Make a run of a scenario in this process, and return its row with further metrics."""
    scenario, metrics = work
    messages: list[str] = []
    with silent():
        run = simulate(scenario, warn=messages.append)
        numbers = numbers_of(measure(run, messages.append, metrics))
    robots = ','.join(map(str, run.failed_robots))
    return _row(number, run.outcome.state, robots, ''.join(messages[:1])) | numbers


def _row(run: int, state: RunState, robots: str = '', message: str = '') -> Row:
    words = ' '.join(message.split())
    if len(words) > _LONGEST_MESSAGE:
        words = f'{words[: _LONGEST_MESSAGE - 1]}…'
    return {'run': run, 'state': state.value, 'robots': robots, 'message': words}
