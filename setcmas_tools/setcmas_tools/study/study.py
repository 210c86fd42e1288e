"""Study: a law run many times, each time in a process of its own; the table of its runs."""

from __future__ import annotations

import multiprocessing
import shutil
import sys
import tempfile
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from tabulate import tabulate
from tqdm import tqdm

from setcmas_ctrl.laws.control_options import Algo
from setcmas_simu.errors import SetcmasError, file_errors, needs
from setcmas_simu.limited_file import written_whole
from setcmas_simu.option_kinds import DURATION, Whole
from setcmas_tools.measures.metric import Metric
from setcmas_tools.measures.metrics import measure
from setcmas_tools.offline.offline_simulation import checked_steps, silent, simulate
from setcmas_tools.offline.run_progress import size_of
from setcmas_tools.offline.script_process import (
    UNGUARDED,
    ScriptEndedError,
    ScriptProcess,
    StartError,
)
from setcmas_tools.run.run import Run, tool
from setcmas_tools.run.run_folder import STUDY_TABLE, RunFolder, inputs_of, kept_record
from setcmas_tools.run.run_info import INFO_FILE, RunInfo, RunState
from setcmas_tools.run.scenario import Scenario, name_of
from setcmas_tools.study.study_columns import COLUMNS, OUTCOME, numbers_of
from setcmas_tools.study.study_plan import (
    SEED,
    Plan,
    Variation,
    make_plan,
    value_in_table,
    with_values,
)

with needs('study'):
    import joblib
    import pandas as pd

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LONGEST_MESSAGE = 300

_WARM_UP = 'setcmas_tools.study.warm_up'

Row = dict[str, Any]
"""A row by column: 'run', its outcome, and its metrics."""


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
        output: Folder of the study. None keeps the study only as long as it is used.
        options: `jobs` and `timeout`, as on the command line; all other arguments of `simulate`.

    Raises:
        SetcmasError: An argument is invalid, or the folder holds something else.
    """
    if multiprocessing.parent_process():  # a script without that line, as a worker imports it
        raise StartError(UNGUARDED)
    jobs, timeout = options.pop('jobs', None), options.pop('timeout', 60.0)
    Whole(1).check('seeds', seeds)
    if jobs is not None:
        Whole(1).check('jobs', jobs)
    DURATION.check('timeout', timeout)
    sizes = {'nb_robots': nb_robots, 'duration': duration}
    options |= {name: value for name, value in sizes.items() if value is not None}
    base = Scenario.of(scenario, **options)
    plan = make_plan(base, (vary or {}).items(), seeds, metrics)
    return carry_out(plan, Path(output) if output else None, jobs, timeout)


def carry_out(
    plan: Plan,
    folder: Path | None,
    jobs: int | None,
    timeout: float,
    overwrite: bool = False,
) -> Study:
    """Make the runs of a study in a folder, or raise SetcmasError.

    If `folder` is None, it is a temporary one. Its run.yaml has the scenario of the first run; the
    scripts of all are in inputs/. An interrupted study keeps its finished runs.
    """
    place = folder or Path(tempfile.mkdtemp(prefix='setcmas_study_'))
    base = plan.scenario(1).found()
    inputs = inputs_of(base)
    # Those of run 1 are written last: they win if scripts have the same name.
    of_all = [one for case in plan.cases() for one in inputs_of(case.found())]
    files = RunFolder(place, of_all[::-1])
    files.check(overwrite)
    files.create(RunInfo(scenario=kept_record(base, inputs)))
    with file_errors(f"study '{place}' cannot be written"):
        rows: dict[int, Row] = {}
        try:
            for row in tqdm(made_rows(plan, jobs, timeout), 'runs', len(plan.runs), disable=None):
                rows[row['run']] = row
        finally:
            if rows:
                write_table(plan, rows, place)
    study = Study(base, [*plan.vary], read_table(place), place, plan)
    if not folder:
        weakref.finalize(study, shutil.rmtree, place, ignore_errors=True)
    return study


def made_rows(plan: Plan, jobs: int | None, timeout: float) -> Iterator[Row]:
    """Make the runs of a study, and yield their rows as they finish, or raise SetcmasError.

    `jobs` run at a time, by default as many as there are cores, each for `timeout` s at most.

    A thread controls the process of each run: joblib's own processes could not be ended
    individually when a script hangs, and one that dies would end all. Within
    `joblib.parallel_config('dask')`, the workers of a cluster take the place of the threads.
    """
    parallel = joblib.Parallel(jobs or -1, prefer='threads', return_as='generator_unordered')
    yield from parallel(
        joblib.delayed(made_row)(run, plan.scenario(run), plan.metrics, timeout)
        for run in range(1, len(plan.runs) + 1)
    )


def made_row(
    number: int, scenario: Scenario, metrics: Mapping[str, Metric], timeout: float
) -> Row:
    """Make a run in a process of its own, for a time in s at most; return its row in any case."""
    # Each process imports the main module again, which on a cluster imports all of Dask.
    of_main = [name for name in ('distributed',) if name in sys.modules]
    multiprocessing.set_forkserver_preload([*of_main, _WARM_UP])
    try:
        work = joblib.wrap_non_picklable_objects((scenario, metrics), keep_wrapper=False)
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


_FIGURE = 'setcmas_tools.study.study_plots:figure'
_MOST_CASES = 200
_FIRST = ('disagreement', 'settling_time', 'least_separation', 'communications')


def runs_in_words(count: int, kind: str = '') -> str:
    """Return '1 run' or '20 runs', or runs of a kind: '3 broken runs'."""
    name = f'{kind} run'.lstrip()
    return f'{count:,} {name}{"s" if count != 1 else ""}'


def shown(value: object) -> str:
    """Return a value as text, numbers with 4 digits."""
    return f'{value:.4g}' if isinstance(value, float) else str(value)


@dataclass(frozen=True, repr=False, eq=False)
class Study:
    """A study.

        study = Study.load('study')
            study.table['disagreement']      # a pandas table, with a row for each run
        study.plot('disagreement', by='K')
            study.run(417)                   # repeats this run

    Attributes:
        base: The scenario of the first run.
        names: Varied names, without the seeds.
        table: A row for each run: its number, its values, its seed, its outcome and its metrics.
        plan: Its runs with their values; None if the study was read from its folder.
    """

    base: Scenario
    names: list[str]
    table: pd.DataFrame
    folder: Path
    plan: Plan | None = None

    @classmethod
    def load(cls, folder: str | Path) -> Study:
        """Read a study, or raise SetcmasError."""
        table = read_table(Path(folder))
        names = [*table][1 : [*table].index(SEED)]
        return cls(Scenario.load(Path(folder) / INFO_FILE), names, table, Path(folder))

    def __len__(self) -> int:
        return len(self.table)

    @property
    def metrics(self) -> list[str]:
        """Columns with metrics."""
        return [name for name in self.table if name not in ('run', SEED, *OUTCOME, *self.names)]

    @property
    def is_broken(self) -> pd.Series:
        """Whether each run is not complete, and so gives no data."""
        return self.table['state'] != 'complete'

    def numbers(self, metric: str) -> pd.Series:
        """Return a metric of each run: inf if never reached, NaN for broken runs."""
        if metric not in self.metrics:
            raise SetcmasError(
                f"unknown metric '{metric}'; must be one of {', '.join(self.metrics)}"
            )
        values = self.table[metric].astype(float)
        if metric in COLUMNS and COLUMNS[metric].endless:
            values = values.fillna(np.inf)
        return values.mask(self.is_broken)

    def run(self, number: int) -> Run:
        """Repeat a run, and return it with all its data.

        A study from `load` knows its values as its table has them. It cannot repeat runs of
        functions and of values that have names of their own there.
        """
        if number not in self.table['run'].array:
            raise SetcmasError(f'unknown run {number}; must be from 1 to {len(self)}')
        if self.plan:
            return simulate(self.plan.scenario(number))
        row = self.table[self.table['run'] == number].iloc[0]
        known = {name: None if pd.isna(row[name]) else row[name] for name in self.names}
        values = {name: value_in_table(name, value) for name, value in known.items()}
        return simulate(with_values(self.base, values).replace(seed=int(row[SEED])))

    def plot(self, metric: str, by: str | None = None) -> Figure:
        """Return a plot of a metric over a varied name, by default the first."""
        figure: Figure = tool(_FIGURE)(self, metric, by)
        return figure

    @property
    def title(self) -> str:
        """Title in plots, such as 'consensus, 600 runs'."""
        algo = Path(str(name_of(self.base.law.algo))).stem
        runs = runs_in_words(len(self))
        return f'{algo}, {runs}' if 'algo' not in self.names else runs

    @property
    def summary(self) -> str:
        """Medians over seeds of each case as a table; of all runs if there are too many cases."""
        is_long = len(self) / self.table[SEED].nunique() > _MOST_CASES
        names = [] if is_long else self.names
        metrics = [name for name in _FIRST if name in self.metrics] or self.metrics[:4]
        numbers = {name: self.numbers(name) for name in metrics}
        keys = self.table[names] if names else pd.DataFrame({'': 0}, self.table.index)
        counted = keys.assign(runs=1, broken=self.is_broken, **numbers)
        how = {'runs': 'sum', 'broken': 'sum', **dict.fromkeys(numbers, 'median')}
        cases = counted.groupby([*keys], sort=False, dropna=False).agg(how).reset_index()
        heads = [*names, 'runs', 'broken', *(f'median\n{name}' for name in numbers)]
        rows = [list(map(shown, row)) for row in cases[[*names, *how]].itertuples(index=False)]
        table: str = tabulate(rows, heads, stralign='right', disable_numparse=True)
        return table

    def __repr__(self) -> str:
        varied = f', {", ".join(self.names)} varied' if self.names else ''
        return f'Study({self.title}{varied})'


def write_table(plan: Plan, rows: Mapping[int, Row], folder: Path) -> None:
    """Write the runs.csv of a study from the rows of its runs by number, whole or not at all."""
    table = pd.DataFrame([{**rows[run], **plan.runs[run - 1]} for run in sorted(rows)])
    first = ['run', *plan.vary, SEED, *OUTCOME]
    others = set(table) - {*first}
    known = [name for name in COLUMNS if name in others]
    ordered = table[[*first, *known, *sorted(others - {*known})]]
    with written_whole(folder / STUDY_TABLE) as file:
        ordered.to_csv(file, index=False, float_format='%.9g', lineterminator='\n')


def read_table(folder: Path) -> pd.DataFrame:
    """Read the runs.csv of a study, or raise SetcmasError."""
    try:
        texts = dict.fromkeys(OUTCOME, str)
        table = pd.read_csv(
            folder / STUDY_TABLE, dtype=texts, keep_default_na=False, na_values=['']
        )
        if SEED not in table:
            raise ValueError(f'it has no column {SEED}')
        return table.fillna(dict.fromkeys(OUTCOME, ''))
    except (OSError, ValueError) as error:
        raise SetcmasError(
            f"'{folder / STUDY_TABLE}' cannot be read; it must be the table of a study"
        ) from error
