"""Study: the table of its runs, its plan, its folder, and medians of its groups."""

from __future__ import annotations

import html as markup
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.table import Table
from setcmas_tools.offline.engine import simulate
from setcmas_tools.run.run import Run, data_frame, tool
from setcmas_tools.study.plan import Plan, read_plan
from setcmas_tools.study.study_columns import COLUMNS
from setcmas_tools.study.study_table import FILE_NAME, TOLD, read_table
from setcmas_tools.study.success import Success, share_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Group:
    """The runs of a study that differ in nothing but their seeds, or in names left aside.

    Attributes:
        values: What they have in common, by name.
        rows: Their places in the table, from 0.
    """

    values: Mapping[str, Any]
    rows: Sequence[int]


def runs_in_words(count: int, kind: str = '') -> str:
    """Return '1 run' or '20 runs', or those of a kind: '3 broken runs'."""
    name = f'{kind} run'.lstrip()
    return f'{count:,} {name}{"s" if count != 1 else ""}'


def median(values: Floats) -> float:
    """Return the median of values without NaN; inf is larger than all others."""
    return float(quantiles(values, 0.5)[0])


def quantiles(values: Floats, *shares: float) -> Floats:
    """Return quantiles of values without NaN, of which some may be inf; NaN if there are none.

    Source of the definition: inverse of the empirical distribution function, with the midpoint
    where it steps, so that half is the median; Hyndman and Fan, The American Statistician 50(4),
    1996, type 2. That of numpy makes NaN of inf.
    """
    known = np.sort(values[~np.isnan(values)])
    if not len(known):
        return np.full(len(shares), np.nan)
    places = len(known) * np.array(shares)
    below, above = np.ceil(places) - 1, np.minimum(np.floor(places), len(known) - 1)
    return np.asarray((known[below.astype(int)] + known[above.astype(int)]) / 2)


_FIGURE = 'setcmas_tools.study.study_plots:figure'
_SUMMARY = 'setcmas_tools.study.study:summary'


@dataclass(frozen=True, repr=False, eq=False)
class Study:
    """A study.

        study = Study.load('study')
        study['disagreement']            # of each run, NaN where there is none
        study.plot('disagreement', by='K')
        study.run(417)                   # that run, made again

    Attributes:
        plan: What it is.
        table: What became of its runs, by column: None in a column of numbers is none.
        folder: What holds it.
    """

    plan: Plan
    table: Mapping[str, Sequence[Any]]
    folder: Path

    @classmethod
    def load(cls, folder: str | Path) -> Study:
        """Read a study that is finished.

        Raises:
            SetcmasError: There is none, or a file is damaged.
        """
        plan = read_plan(Path(folder))
        return cls.of(plan, Path(folder))

    @classmethod
    def of(cls, plan: Plan, folder: Path) -> Study:
        """Return the study of a plan whose table is in a folder.

        Raises:
            SetcmasError: The table is damaged, or the plan's success names no column.
        """
        study = cls(plan, read_table(folder / FILE_NAME), folder)
        if plan.info.success:
            study.successes(plan.info.success)
        return study

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.plan.cases)

    def __getitem__(self, column: str) -> Any:
        """Return a column as an array: numbers, NaN where there is none, or words.

        Raises:
            SetcmasError: There is no such column.
        """
        _check_name('column', column, list(self.table))
        values = self.table[column]
        if column in TOLD or any(isinstance(value, str) for value in values):
            return np.array(values, dtype=object)
        return np.array(values, dtype=float)

    @property
    def names(self) -> list[str]:
        """What is varied, without the seeds."""
        return self.plan.cases.names

    @property
    def metrics(self) -> list[str]:
        """The columns that the runs are measured by."""
        return [name for name in self.table if name not in ('run', 'seed', *TOLD, *self.names)]

    @cached_property
    def _successes(self) -> dict[str, list[bool]]:
        return {}

    @cached_property
    def measured(self) -> Any:
        """Whether each run is complete; all others are broken, and no data."""
        return self['state'] == 'complete'

    def numbers(self, metric: str) -> Floats:
        """Return a metric of each run: inf for what was never reached, NaN of broken runs.

        Raises:
            SetcmasError: There is no such metric.
        """
        _check_name('metric', metric, self.metrics)
        values: Floats = self[metric].copy()
        if metric in COLUMNS and COLUMNS[metric].endless:
            values[np.isnan(values)] = np.inf
        values[~self.measured] = np.nan
        return values

    def groups(self, *names: str) -> Iterator[Group]:
        """Yield the runs with equal values of some names: numbers sorted, words as they come.

        Raises:
            SetcmasError: A name is not varied.
        """
        for name in names:
            if name not in self.names:
                known = ', '.join(self.names) or 'nothing'
                raise SetcmasError(f"'{name}' is not varied in this study; it varies {known}")
        found: dict[tuple[Any, ...], list[int]] = {}
        for row, values in enumerate(zip(*(self.table[name] for name in names), strict=True)):
            found.setdefault(values, []).append(row)
        if not names:
            found[()] = list(range(len(self)))
        numeric = all(isinstance(value, float) for values in found for value in values)
        for values, rows in sorted(found.items()) if numeric else found.items():
            yield Group(dict(zip(names, values, strict=True)), rows)

    def successes(self, expression: str | None = None) -> list[bool]:
        """Return which runs are successes; a run that did not end as it should is none.

        Args:
            expression: Such as 'disagreement < 0.1'; by default that of the study.

        Raises:
            SetcmasError: There is none, or it names what is no column.
        """
        text = expression or self.plan.info.success
        if not text:
            raise SetcmasError('a success must be given, such as success="disagreement < 0.1"')
        if text not in self._successes:
            columns = {name: np.full(len(self), np.nan) for name in COLUMNS}
            columns |= {name: self[name] for name in (*self.names, 'seed')}
            columns |= {name: self.numbers(name) for name in self.metrics}
            success = Success(text, columns)
            self._successes[text] = [
                state == 'complete' and success.of({n: c[row] for n, c in columns.items()})
                for row, state in enumerate(self['state'])
            ]
        return self._successes[text]

    def run(self, number: int) -> Run:
        """Make a run again, and return it with all that happened in it.

        Raises:
            SetcmasError: There is no such run, or a file that it needs is missing.
        """
        return simulate(self.plan.scenario(number, self.folder))

    def plot(self, metric: str, by: str | Sequence[str] | None = None, **look: Any) -> Figure:
        """Return a plot.

        Args:
            metric: A column, 'success', or 'tradeoff' (communications against settling time).
            by: What is varied along the axis; two names make a map. By default the first.
            look: `success`, an expression in place of the study's; `palette` and `paper` as
                for csv_to_plot.

        Raises:
            SetcmasError: There is no such column or style, or nothing is varied.
        """
        figure: Figure = tool(_FIGURE)(self, metric, by, **look)
        return figure

    def to_dataframe(self) -> Any:
        """Return the table as a pandas DataFrame.

        Raises:
            SetcmasError: pandas is missing.
        """
        return data_frame({name: self[name] for name in self.table})

    @property
    def title(self) -> str:
        """What the study is called in plots, such as 'consensus, 600 runs'."""
        algo = Path(str(self.plan.info.scenario['algo'])).stem
        runs = runs_in_words(len(self))
        return f'{algo}, {runs}' if 'algo' not in self.names else runs

    @property
    def summary(self) -> str:
        """The medians over seeds of each case as a table; of all runs if there are too many."""
        return str(tool(_SUMMARY)(self))

    def __repr__(self) -> str:
        """Return one line."""
        varied = f', {", ".join(self.names)} varied' if self.names else ''
        return f'Study({self.title}{varied})'

    def _repr_html_(self) -> str:
        title, summary = markup.escape(self.title), markup.escape(self.summary)
        return f'<div><b>{title}</b><pre style="line-height:1.2">{summary}</pre></div>'


def _check_name(kind: str, name: str, names: list[str]) -> None:
    if name not in names:
        raise SetcmasError(f"there is no {kind} '{name}'; it must be one of {', '.join(names)}")


_MOST_GROUPS = 40
_FIRST = ('disagreement', 'settling_time', 'least_separation', 'communications')


def summary(study: Study) -> str:
    """Return the medians over seeds and draws of each case; of all runs if there are too many."""
    names = [name for name in study.names if name not in study.plan.cases.draws]
    groups = list(study.groups(*names))
    if len(groups) > _MOST_GROUPS:
        names, groups = [], list(study.groups())
    metrics = [name for name in _FIRST if name in study.metrics] or study.metrics[:4]
    heads = [*names, 'runs', 'broken', *(f'median\n{name}' for name in metrics)]
    heads += ['success'] if study.plan.info.success else []
    rows = [[_cell(value) for value in _summed_up(study, group, metrics)] for group in groups]
    return str(Table(rows, heads, 'r'))


def _cell(value: object) -> str:
    return f'{value:.4g}' if isinstance(value, float) else str(value)


def _summed_up(study: Study, group: Group, metrics: Sequence[str]) -> list[Any]:
    rows = [row for row in group.rows if study.measured[row]]
    told: list[Any] = [*group.values.values(), len(group.rows), len(group.rows) - len(rows)]
    told += [median(study.numbers(name)[rows]) for name in metrics]
    if study.plan.info.success:
        share, low, high = share_of([study.successes()[row] for row in group.rows])
        told.append(f'{100 * share:.0f} % ({100 * low:.0f} to {100 * high:.0f})')
    return told
