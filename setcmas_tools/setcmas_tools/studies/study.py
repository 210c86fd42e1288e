"""Study: the table of its runs, its plan and its folder."""

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
from setcmas_tools.run.run import Run
from setcmas_tools.run.tools import data_frame, tool
from setcmas_tools.studies.cases.plan import Plan, read_plan
from setcmas_tools.studies.columns import COLUMNS
from setcmas_tools.studies.groups import Group, runs_in_words
from setcmas_tools.studies.success import Success
from setcmas_tools.studies.table import FILE_NAME, TOLD, read_table
from setcmas_tools.studies.workers.row import run_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FIGURE = 'setcmas_tools.studies.plots:figure'
_SUMMARY = 'setcmas_tools.studies.summary:summary'


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
        kept = self.plan.parameters(number, lambda name: str(self.folder / name))
        return run_of(kept, print)

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
        algo = Path(str(self.plan.info.parameters['algo'])).stem
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
