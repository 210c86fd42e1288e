"""The run of a page, and perhaps another one over it: their metrics, differences and plots."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from setcmas_simu.errors import SetcmasError
from setcmas_simu.table import Table
from setcmas_tools.compare.differences import differences, metrics_table
from setcmas_tools.compare.experiment_verdict import ExperimentVerdict, experiment_verdict
from setcmas_tools.compare.pictures import drawn_pictures
from setcmas_tools.compare.run_distance import Shifted, best_shift
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_table
from setcmas_tools.plots.plot import drawn_plots
from setcmas_tools.plots.style import plot_style
from setcmas_tools.run.run import Run

_DPI = 110
_COLOURS = 128
"""Enough for lines and letters with smooth edges."""


@dataclass(frozen=True)
class Pair:
    """A run and another one, which may be missing.

    Attributes:
        name: What the run is called.
        run: The run.
        other_name: What the other one is called; empty if there is none.
        other: The other one.
        warn: Shows what cannot be measured or drawn.
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
        """How far the other run is from this one; None if no robot is in both."""
        if self.other is None:
            return None
        try:
            return best_shift(self.run, self.other)
        except SetcmasError as error:
            self.warn(str(error))
            return None

    @property
    def headline(self) -> str:
        """The same in words; empty if there is none."""
        return f'{self.other_name} {self.shifted}' if self.shifted else ''

    @property
    def differences(self) -> list[str]:
        """The options in which the runs differ, one a line."""
        return differences(self.run, self.other) if self.other else []

    @cached_property
    def verdict(self) -> ExperimentVerdict | None:
        """Whether a simulation explains its experiment, if the two runs are those."""
        if self.other is None or len(self.paths) != 2:
            return None
        return experiment_verdict(self.paths, [self.run, self.other], self.warn)

    def metrics(self) -> tuple[Table, list[str]]:
        """Return a table of metrics, and the lines below it."""
        try:
            own = measure(self.run, self.warn)
            if self.other is None:
                return robots_table(own.parts), fleet_lines(own.parts, own.task)
            both = [own, measure(self.other, self.warn)]
        except SetcmasError as error:
            return Table([]), [str(error)]
        return metrics_table([self.name, self.other_name], both), []

    def figures(self) -> Iterator[tuple[str, Figure]]:
        """Yield the plots by name, those of both runs first; used within `plot_style`."""
        if self.other and self.shifted:
            names, runs = [self.name, self.other_name], [self.run, self.other]
            yield from drawn_pictures(names, runs, [self.shifted]).items()
        yield from drawn_plots(self.run, self.warn)


@dataclass(frozen=True)
class EmbeddedPicture:
    """A plot.

    Attributes:
        name: That of the plot.
        address: A data URL.
    """

    name: str
    address: str


def embedded_pictures(pair: Pair) -> Iterator[EmbeddedPicture]:
    """Yield the plots."""
    with plot_style():
        for name, figure in pair.figures():
            kinds = {'image/svg+xml': _svg(figure), 'image/png': _png(figure)}
            kind = min(kinds, key=lambda one: len(kinds[one]))
            content = base64.b64encode(kinds[kind]).decode('ascii')
            yield EmbeddedPicture(name, f'data:{kind};base64,{content}')


def _svg(figure: Figure) -> bytes:
    content = io.BytesIO()
    figure.savefig(content, format='svg', metadata={'Date': None})
    return content.getvalue()


def _png(figure: Figure) -> bytes:
    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format='png', dpi=_DPI)
    picture = Image.open(drawn).convert('RGB')
    picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(small, format='png', optimize=True)
    return small.getvalue()
