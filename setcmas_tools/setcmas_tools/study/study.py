"""Study: the table of its runs, its plan, its folder, and medians of groups."""

from __future__ import annotations

import html as markup
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from tabulate import tabulate

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.engine import simulate
from setcmas_tools.run.run import Run, data_frame, tool
from setcmas_tools.study.study_columns import COLUMNS, predicted
from setcmas_tools.study.study_plan import Plan, read_plan
from setcmas_tools.study.study_table import FILE_NAME, OUTCOME, read_table
from setcmas_tools.study.success import Success, share_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Group:
    """Runs of a study that differ only in their seeds, or in ignored names.

    Attributes:
        values: Their common values, by name.
        rows: Their rows in the table, from 0.
    """

    values: Mapping[str, Any]
    rows: Sequence[int]

    def __str__(self) -> str:
        """Return the values, such as 'K = 2, graph = ring'."""
        return ', '.join(f'{name} = {shown(value)}' for name, value in self.values.items())


def shown(value: object) -> str:
    """Return a value as text, numbers with 4 digits."""
    return f'{value:.4g}' if isinstance(value, float) else str(value)


def runs_in_words(count: int, kind: str = '') -> str:
    """Return '1 run' or '20 runs', or runs of a kind: '3 broken runs'."""
    name = f'{kind} run'.lstrip()
    return f'{count:,} {name}{"s" if count != 1 else ""}'


def median(values: Floats) -> float:
    """Return the median of values without NaN; inf is the largest value."""
    return float(quantiles(values, 0.5)[0])


def quantiles(values: Floats, *shares: float) -> Floats:
    """Return quantiles of values without NaN, possibly with inf; NaN without values.

    Definition: inverse of the empirical distribution function, with the midpoint at its steps, so
    that 0.5 gives the median; Hyndman and Fan, The American Statistician 50(4), 1996, type 2.
    numpy's version turns inf into NaN.
    """
    known = np.sort(values[~np.isnan(values)])
    if not len(known):
        return np.full(len(shares), np.nan)
    places = len(known) * np.array(shares)
    below, above = np.ceil(places) - 1, np.minimum(np.floor(places), len(known) - 1)
    return np.asarray((known[below.astype(int)] + known[above.astype(int)]) / 2)


_FIGURE = 'setcmas_tools.study.study_plots:figure'


@dataclass(frozen=True, repr=False, eq=False)
class Study:
    """A study.

        study = Study.load('study')
            study['disagreement']            # a value per run, NaN if missing
        study.plot('disagreement', by='K')
            study.run(417)                   # repeats this run

    Attributes:
        table: Results of its runs by column; None in a column of numbers means no value.
    """

    plan: Plan
    table: Mapping[str, Sequence[Any]]
    folder: Path

    @classmethod
    def load(cls, folder: str | Path) -> Study:
        """Read a finished study.

        Raises:
            SetcmasError: There is no study, or a file is damaged.
        """
        plan = read_plan(Path(folder))
        return cls.of(plan, Path(folder))

    @classmethod
    def of(cls, plan: Plan, folder: Path) -> Study:
        """Return the study of a plan, with the table in a folder.

        Raises:
            SetcmasError: The table is damaged, or the plan's success condition has an unknown
                column.
        """
        study = cls(plan, read_table(folder / FILE_NAME), folder)
        if plan.info.success:
            study.successes(plan.info.success)
        return study

    def __len__(self) -> int:
        return len(self.plan.cases)

    def __getitem__(self, column: str) -> Any:
        """Return a column as an array: numbers, NaN if missing, or strings.

        Raises:
            SetcmasError: The column is unknown.
        """
        _check_name('column', column, list(self.table))
        values = self.table[column]
        if column in OUTCOME or any(isinstance(value, str) for value in values):
            return np.array(values, dtype=object)
        return np.array(values, dtype=float)

    @property
    def names(self) -> list[str]:
        """Varied names, without the seeds."""
        return self.plan.cases.names

    @property
    def metrics(self) -> list[str]:
        """Columns with metrics."""
        return [name for name in self.table if name not in ('run', 'seed', *OUTCOME, *self.names)]

    @cached_property
    def _successes(self) -> dict[str, list[bool]]:
        return {}

    @cached_property
    def measured(self) -> Any:
        """Whether each run is complete; all others are broken and give no data."""
        return self['state'] == 'complete'

    def numbers(self, metric: str) -> Floats:
        """Return a metric of each run: inf if never reached, NaN for broken runs.

        Raises:
            SetcmasError: The metric is unknown.
        """
        _check_name('metric', metric, self.metrics)
        values: Floats = self[metric].copy()
        if metric in COLUMNS and COLUMNS[metric].endless:
            values[np.isnan(values)] = np.inf
        values[~self.measured] = np.nan
        return values

    def groups(self, *names: str) -> Iterator[Group]:
        """Yield groups of runs with equal values of some names: numbers sorted, strings in order.

        Raises:
            SetcmasError: A name is not varied.
        """
        for name in names:
            if name not in self.names:
                known = ', '.join(self.names) or 'nothing'
                raise SetcmasError(f"'{name}' is not varied in this study; must be one of {known}")
        found: dict[tuple[Any, ...], list[int]] = {}
        for row, values in enumerate(zip(*(self.table[name] for name in names), strict=True)):
            found.setdefault(values, []).append(row)
        if not names:
            found[()] = list(range(len(self)))
        numeric = all(isinstance(value, float) for values in found for value in values)
        for values, rows in sorted(found.items()) if numeric else found.items():
            yield Group(dict(zip(names, values, strict=True)), rows)

    def successes(self, expression: str | None = None) -> list[bool]:
        """Return which runs are successes; broken runs never are.

        Args:
            expression: For example 'disagreement < 0.1'; by default that of the study.

        Raises:
            SetcmasError: There is no expression, or it has an unknown column.
        """
        text = expression or self.plan.info.success
        if not text:
            raise SetcmasError(
                'no success condition; give one, such as success="disagreement < 0.1"'
            )
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
        """Repeat a run, and return it with all its data.

        Raises:
            SetcmasError: The run does not exist, or a file that it needs is missing.
        """
        return simulate(self.plan.scenario(number, self.folder))

    def plot(self, metric: str, by: str | Sequence[str] | None = None, **look: Any) -> Figure:
        """Return a plot.

        Args:
            metric: A column, 'success', or 'tradeoff' (communications over settling time).
            by: Varied name for the axis; two names make a map. By default the first.
            look: `success`, an expression instead of the study's; `palette` and `paper` as
                for csv_to_plot.

        Raises:
            SetcmasError: A column or style is unknown, or nothing is varied.
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
        """Title in plots, such as 'consensus, 600 runs'."""
        algo = Path(str(self.plan.info.scenario['algo'])).stem
        runs = runs_in_words(len(self))
        return f'{algo}, {runs}' if 'algo' not in self.names else runs

    @property
    def summary(self) -> str:
        """Medians over seeds of each case as a table; of all runs if there are too many cases."""
        return summary(self)

    def __repr__(self) -> str:
        varied = f', {", ".join(self.names)} varied' if self.names else ''
        return f'Study({self.title}{varied})'

    def _repr_html_(self) -> str:
        title, summary = markup.escape(self.title), markup.escape(self.summary)
        return f'<div><b>{title}</b><pre style="line-height:1.2">{summary}</pre></div>'


def _check_name(kind: str, name: str, names: list[str]) -> None:
    if name not in names:
        raise SetcmasError(f"unknown {kind} '{name}'; must be one of {', '.join(names)}")


_MOST_GROUPS = 200
_FIRST = ('disagreement', 'settling_time', 'least_separation', 'communications')


def summary(study: Study) -> str:
    """Return medians over seeds and draws of each case; of all runs if there are too many."""
    names = [name for name in study.names if name not in study.plan.cases.draws]
    groups = list(study.groups(*names))
    if len(groups) > _MOST_GROUPS:
        names, groups = [], list(study.groups())
    metrics = [name for name in _FIRST if name in study.metrics] or study.metrics[:4]
    metrics += [name for name in study.metrics if predicted(name) in study.metrics]
    metrics = [one for name in dict.fromkeys(metrics) for one in (name, predicted(name))]
    metrics = [name for name in metrics if name in study.metrics]
    heads = [*names, 'runs', 'broken', *map(_head, metrics)]
    heads += ['success'] if study.plan.info.success else []
    rows = [[shown(value) for value in _summed_up(study, group, metrics)] for group in groups]
    table: str = tabulate(rows, heads, stralign='right', disable_numparse=True)
    return table


def _head(metric: str) -> str:
    return 'predicted' if metric.startswith('prediction_') else f'median\n{metric}'


def _summed_up(study: Study, group: Group, metrics: Sequence[str]) -> list[Any]:
    rows = [row for row in group.rows if study.measured[row]]
    cells: list[Any] = [*group.values.values(), len(group.rows), len(group.rows) - len(rows)]
    cells += [median(study.numbers(name)[rows]) for name in metrics]
    if study.plan.info.success:
        share, low, high = share_of([study.successes()[row] for row in group.rows])
        cells.append(f'{100 * share:.0f} % ({100 * low:.0f} to {100 * high:.0f})')
    return cells
