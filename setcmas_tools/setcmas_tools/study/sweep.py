"""Sweep: the missing runs of a plan, made and added to its study."""

from __future__ import annotations

import inspect
import os
import shutil
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

from tqdm import tqdm

from setcmas_simu.errors import SetcmasError, needs
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.fleet_laws import Algo
from setcmas_tools.study.plan import Plan, Variation, make_plan
from setcmas_tools.study.study import Study
from setcmas_tools.study.study_folder import prepare, written
from setcmas_tools.study.study_options import SweepOptions
from setcmas_tools.study.study_row import Job, memory_of_each
from setcmas_tools.study.study_table import PartialTable
from setcmas_tools.study.study_workers import Workers

_NOT_OPTIONS = {'settings', 'warn', 'progress'}


def sweep(
    algo: Algo,
    nb_robots: int = 1,
    duration: float = 40.0,
    *,
    vary: Mapping[str, Variation] | None = None,
    seeds: int = 1,
    output: str | Path | None = None,
    **options: Any,
) -> Study:
    """Run a control law many times, with some of its parameters varied.

        from setcmas_tools import sweep

        study = sweep('consensus', 8, 60, vary={'K': '0.2:2:10', 'loss': [0, 0.2]}, seeds=20)
        study.plot('settling_time', by='K')
        study.to_dataframe()

    Args:
        algo: As for `simulate`.
        nb_robots: Number of robots.
        duration: Length of each run in s.
        vary: What is varied: arguments of `simulate`, and names of the script. Values are a
            sequence, a text as for `--vary`, or a dictionary from what a value is called to the
            value, for functions and matrices. All combinations are run.
        seeds: Number of seeds for each of them.
        output: Folder of the study; one that holds the same study already goes on. None keeps
            the study as long as it is used.
        options: `success`, `cases`, `jobs`, `cluster`, `timeout`, as on the command line;
            whatever else `simulate` takes.

    Raises:
        SetcmasError: An argument makes no sense, or the folder holds something else.
    """
    own = SweepOptions.__dataclass_fields__.keys() & options.keys()
    chosen = SweepOptions(seeds=seeds, **{name: options.pop(name) for name in own})
    known = inspect.signature(simulate).parameters
    if strangers := sorted(options.keys() - known.keys()):
        raise SetcmasError(f"'{strangers[0]}' is no argument of sweep or simulate")
    defaults = {n: one.default for n, one in known.items() if n not in _NOT_OPTIONS}
    given = {n: value for n, value in options.items() if n not in _NOT_OPTIONS}
    first = {'algo': algo, 'nb_robots': nb_robots, 'duration': duration}
    parameters = {**defaults, **given, **first, 'set': dict(options.get('settings') or {})}
    plan = make_plan(parameters, vary or {}, chosen.cases, seeds, chosen.success)
    return carry_out(plan, Path(output) if output else None, chosen)


def carry_out(
    plan: Plan, folder: Path | None, options: SweepOptions, overwrite: bool = False
) -> Study:
    """Make the runs of a study that are not there yet.

    Args:
        plan: The study.
        folder: Its folder; None is a temporary one.
        options: Who makes the runs, and how long each may take.
        overwrite: Whether to replace another study.

    Raises:
        SetcmasError: The folder holds something else or cannot be written, or the cluster does
            not answer.
    """
    place = folder or Path(tempfile.mkdtemp(prefix='setcmas_study_'))
    if not prepare(place, plan, overwrite):
        with written(place), PartialTable(place) as table:
            left = [run for run in range(1, len(plan.cases) + 1) if run not in table.done]
            done = len(plan.cases) - len(left)
            jobs = jobs_of(plan, left, options)
            with closing(_workers(options).rows(jobs)) as rows:
                for row in tqdm(rows, 'runs', len(plan.cases), initial=done, disable=None):
                    table.add(row)
            table.finish(plan.cases)
    study = Study.of(plan, place)
    if not folder:
        weakref.finalize(study, shutil.rmtree, place, ignore_errors=True)
    return study


def jobs_of(plan: Plan, runs: Iterable[int], options: SweepOptions) -> Iterator[Job]:
    """Yield the jobs of some runs; those of a cluster take the files along."""
    with needs('study'):
        import cloudpickle

    remote = options.cluster is not None
    memory = memory_of_each(os.cpu_count() or 1 if remote else options.jobs)
    for run in runs:
        pickled = cloudpickle.dumps(plan.parameters(run, None if remote else plan.original))
        files = plan.files.contents if remote else None
        yield Job(run, pickled, options.timeout, memory, files)


def _workers(options: SweepOptions) -> Workers:
    return Workers(options.jobs, options.cluster)
