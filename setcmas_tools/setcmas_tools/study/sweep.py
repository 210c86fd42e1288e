"""Sweep: makes the missing runs of a study."""

from __future__ import annotations

import multiprocessing
import shutil
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tqdm import tqdm

from setcmas_ctrl.control.control_options import Algo
from setcmas_tools.measures.metric import Metric
from setcmas_tools.offline.script_process import UNGUARDED, StartError
from setcmas_tools.scenario.scenario import Scenario
from setcmas_tools.study.study import Study, table_of
from setcmas_tools.study.study_files import (
    TABLE,
    finished_rows,
    prepare,
    stored_rows,
    write_table,
    written,
)
from setcmas_tools.study.study_options import SweepOptions
from setcmas_tools.study.study_plan import Plan, Variation, make_plan
from setcmas_tools.study.study_run import made_rows


def sweep(
    scenario: Scenario | Algo,
    nb_robots: int | None = None,
    duration: float | None = None,
    *,
    vary: Mapping[str, Variation] | None = None,
    seeds: int = 1,
    metrics: Mapping[str, Metric] | None = None,
    output: str | Path | None = None,
    **options: Any,
) -> Study:
    """Run a scenario many times, with some of its values varied.

        from setcmas_tools import sweep

        if __name__ == '__main__':  # in a script, not in a notebook: runs are other processes
            study = sweep('consensus', 8, 60, vary={'K': '0.2:2:10', 'loss': [0, 0.2]}, seeds=20)
            study.table.groupby('K')['disagreement'].median()
            study.plot('settling_time', by='K')

    Args:
        scenario: As for `simulate`.
        nb_robots: Number of robots.
        duration: Length of each run in s.
        vary: Values of options and of variables of the script, by name: a sequence, a text as
            for `--vary`, or a dictionary by label, for functions and matrices. All
            combinations are run.
        seeds: Number of seeds for each of them.
        metrics: Further metrics by name: functions of a run, which become columns.
        output: Folder of the study. If it holds the same study, perhaps with fewer seeds, only
            the missing runs are made. None keeps the study as long as it is used.
        options: `cases`, `jobs`, `cluster`, `timeout`, as on the command line; all other
            arguments of `simulate`.

    Raises:
        SetcmasError: An argument is invalid, or the folder holds something else.
    """
    if multiprocessing.parent_process():  # a script without that line, as a worker imports it
        raise StartError(UNGUARDED)
    own = SweepOptions.__dataclass_fields__.keys() & options.keys()
    given = {name: options.pop(name) for name in own}
    if given.get('cases'):
        given['cases'] = Path(given['cases'])
    chosen = SweepOptions(seeds=seeds, **given)
    sizes = {'nb_robots': nb_robots, 'duration': duration}
    options |= {name: value for name, value in sizes.items() if value is not None}
    if isinstance(scenario, Scenario):
        base = scenario.replace(**options)
    else:
        base = Scenario.of(scenario, **options)
    plan = make_plan(base, vary or {}, chosen.cases, seeds, metrics)
    return carry_out(plan, Path(output) if output else None, chosen)


def carry_out(
    plan: Plan, folder: Path | None, options: SweepOptions, overwrite: bool = False
) -> Study:
    """Make the missing runs of a study in a folder, or raise SetcmasError.

    The folder None is a temporary one.
    """
    place = folder or Path(tempfile.mkdtemp(prefix='setcmas_study_'))
    with written(place):
        prepare(place, plan.info, plan.contents, overwrite)
        rows = finished_rows(place)
        left = [run for run in range(1, len(plan.runs) + 1) if run not in rows]
        made = made_rows(plan, left, options) if left else ()
        stored, before = stored_rows(place, made), len(rows)
        for row in tqdm(stored, 'runs', len(plan.runs), initial=before, disable=None):
            rows[row['run']] = row
        if left or not (place / TABLE).is_file():
            write_table(table_of(plan, rows), place)
    study = Study.load(place, plan)
    if not folder:
        weakref.finalize(study, shutil.rmtree, place, ignore_errors=True)
    return study
