"""The run of a report, and perhaps another one beside it: what both pages tell of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from matplotlib.figure import Figure

from setcmas_simu.errors import SetcmasError
from setcmas_tools.compare.differences import differences, metrics_table
from setcmas_tools.compare.experiment_verdict import ExperimentVerdict, experiment_verdict
from setcmas_tools.compare.pictures import drawn_pictures
from setcmas_tools.compare.run_distance import Shifted, best_shift
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_table
from setcmas_tools.plots.plot import drawn_plots
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class Pair:
    """A run and another one, which may be missing.

    Attributes:
        name: What the run is called.
        run: The run.
        other_name: What the other one is called; empty if there is none.
        other: The other one.
        warn: Shows what cannot be measured or drawn; the rest is told.
        paths: Where both are, if they are in files.
    """

    name: str
    run: Run
    other_name: str = ''
    other: Run | None = None
    warn: Callable[[str], None] = print
    paths: Sequence[Path] = ()

    @cached_property
    def shifted(self) -> Shifted | None:
        """How far the other run is from this one; None if nothing is in both."""
        if self.other is None:
            return None
        try:
            return best_shift(self.run, self.other)
        except SetcmasError as error:
            self.warn(str(error))
            return None

    @property
    def beside(self) -> str:
        """That in words; empty if there is nothing to tell."""
        return f'{self.other_name} {self.shifted}' if self.shifted else ''

    @property
    def differences(self) -> list[str]:
        """What the other run was given in another way."""
        return differences(self.run, self.other) if self.other else []

    @cached_property
    def verdict(self) -> ExperimentVerdict | None:
        """How an experiment and its simulation go together, if the two runs are that."""
        if self.other is None or len(self.paths) != 2:
            return None
        return experiment_verdict(self.paths, [self.run, self.other], self.warn)

    def metrics(self, form: str) -> tuple[str, list[str]]:
        """Return a table of metrics, and what stands below it.

        Args:
            form: A format of tabulate, 'simple' or 'html'.
        """
        try:
            own = measure(self.run, self.warn)
            if self.other is None:
                return robots_table(own.parts, form), fleet_lines(own.parts, own.task)
            both = [own, measure(self.other, self.warn)]
        except SetcmasError as error:
            return '', [str(error)]
        return metrics_table([self.name, self.other_name], both, form), []

    def figures(self) -> Iterator[tuple[str, Figure]]:
        """Yield the plots by name, those of both runs first; used within `plot_style`."""
        if self.other and self.shifted:
            names, runs = [self.name, self.other_name], [self.run, self.other]
            yield from drawn_pictures(names, runs, [self.shifted]).items()
        yield from drawn_plots(self.run, self.warn)
