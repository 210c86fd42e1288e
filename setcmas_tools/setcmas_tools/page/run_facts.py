"""Facts of a run for its page, and of a pair of runs."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.script_calls import ScriptFailure
from setcmas_tools.measures.comparison import Shifted, best_shift, differences, metrics_table
from setcmas_tools.measures.metrics import fleet_lines, measure, robots_table
from setcmas_tools.plots.comparison_plots import drawn_pictures
from setcmas_tools.plots.plot import drawn_plots
from setcmas_tools.plots.style import plot_style
from setcmas_tools.run.inputs import RunInput
from setcmas_tools.run.run import Run

_OPTIONS = {
    'algo': 'control law',
    'si_to_uni': 'si_to_uni',
    'ctc': 'triggering condition',
    'model': 'robot model',
}


@dataclass(frozen=True)
class Mark:
    """A failure of a script, for all robots that failed alike.

    Attributes:
        robots: The robots, in words.
        t: Time of the first failure in s.
        when: Its period, in words.
        text: The error, in a line.
        place: File and line, in words; empty if they are not known.
    """

    robot: int
    robots: str
    t: float
    when: str
    text: str
    place: str


Line = tuple[str, list[Mark]]
"""A line of a script, with its failures."""


def listings(run: Run) -> Iterator[tuple[str, str, list[Line]]]:
    """Yield name, role and lines of the scripts of a run, laws first, each with its modules."""
    for option, role in _OPTIONS.items():
        for given in (one for one in run.inputs if one.option == option):
            robots = f' of {robots_in_words(list(given.robots))}' if given.robots else ''
            for file, content in zip(given.files, given.contents, strict=True):
                what = role if file == given.path else f'module of {given.path.name}'
                yield file.name, what + robots, _lines(run, given, file, content)


def _lines(run: Run, given: RunInput, file: Path, content: bytes) -> list[Line]:
    failures = [
        one
        for one in run.info.failures or []
        if one.script == file.name and (not given.robots or one.robot in given.robots)
    ]
    return [
        # `--watch` loads other versions: a failure is shown at the line that it quotes.
        (line, marks_of([one for one in failures if one.line == n and line.strip() in one.text]))
        for n, line in enumerate(content.decode(errors='replace').splitlines() or [''], 1)
    ]


def marks_of(failures: list[ScriptFailure]) -> list[Mark]:
    """Return a mark for all robots that failed alike, sorted by time."""
    alike: dict[tuple[str, int | None, str], list[ScriptFailure]] = {}
    for one in failures:
        kind = one.first_line.partition(':')[0]  # what follows may have numbers in it
        alike.setdefault((one.script, one.line, kind), []).append(one)
    marks = [_mark(ones) for ones in alike.values()]
    return sorted(marks, key=lambda mark: mark.t)


def _mark(ones: list[ScriptFailure]) -> Mark:
    first = min(ones, key=lambda one: one.t)
    robots = robots_in_words(sorted({one.robot for one in ones}))
    times = len([one for one in ones if one.robot == first.robot])
    ends = [one.until for one in ones]
    until = 'to the end' if None in ends else f'to {max(end or 0.0 for end in ends):.1f} s'
    again = f', {times} times' if times > 1 else ''
    place = f'{first.script}, line {first.line}' if first.line else first.script
    when = f't = {first.t:.1f} s {until}{again}'
    return Mark(first.robot, robots, first.t, when, first.first_line, place)


@dataclass(frozen=True)
class Pair:
    """A run, and possibly a second one.

    Attributes:
        name: Name of the run.
        other_name: Name of the second run; empty without one.
        warn: Shows metrics and plots that fail.
    """

    name: str
    run: Run
    other_name: str = ''
    other: Run | None = None
    warn: Callable[[str], None] = print

    @cached_property
    def shifted(self) -> Shifted | None:
        """Distance of the second run from this one; None if no robot is in both."""
        if self.other is None:
            return None
        try:
            return best_shift(self.run, self.other)
        except SetcmasError as error:
            self.warn(str(error))
            return None

    @property
    def headline(self) -> str:
        """That distance in words; empty without a second run."""
        return f'{self.other_name} {self.shifted}' if self.shifted else ''

    @property
    def differences(self) -> list[str]:
        """The options in which the runs differ, one a line."""
        return differences(self.run, self.other) if self.other else []

    def metrics(self) -> tuple[str, list[str]]:
        """Return an HTML table of metrics, and the lines below it."""
        try:
            own = measure(self.run, self.warn)
            if self.other is None:
                return robots_table(own.parts, 'html'), fleet_lines(own.parts)
            both = [own, measure(self.other, self.warn)]
        except SetcmasError as error:
            return '', [str(error)]
        return metrics_table([self.name, self.other_name], both, 'html'), []

    def figures(self) -> Iterator[tuple[str, Figure]]:
        """Yield the plots by name, those of both runs first; used within `plot_style`."""
        if self.other and self.shifted:
            names, runs = [self.name, self.other_name], [self.run, self.other]
            yield from drawn_pictures(names, runs, [self.shifted]).items()
        yield from drawn_plots(self.run, self.warn)


_WIDEST_IN = 9.0
_DPI = 110
_COLOURS = 128
"""Enough for lines and letters with smooth edges."""


@dataclass(frozen=True)
class PlotPicture:
    """A plot of a page.

    Attributes:
        url: The PNG as a data URL.
        share: Its width as a share of the page's, which gives all plots the same letters.
    """

    name: str
    url: str
    share: float


def plot_pictures(pair: Pair) -> Iterator[PlotPicture]:
    """Yield the plots of a run, or of two."""
    with plot_style():
        for name, figure in pair.figures():
            content = base64.b64encode(_png(figure)).decode('ascii')
            share = min(1.0, figure.get_figwidth() / _WIDEST_IN)
            yield PlotPicture(name, f'data:image/png;base64,{content}', share)


def _png(figure: Figure) -> bytes:
    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format='png', dpi=_DPI)
    picture = Image.open(drawn).convert('RGB')
    picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(small, format='png', optimize=True)
    return small.getvalue()
