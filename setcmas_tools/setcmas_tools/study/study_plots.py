"""Plots of a study: medians of metrics over varied names, with bars of 90 % of the runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure

from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metric import words_and_unit
from setcmas_tools.plots.plot import Picture
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.plots.style import as_written, finish, legend, plot_style, write_figures
from setcmas_tools.study.study import Study, runs_in_words, shown
from setcmas_tools.study.study_columns import COLUMNS

if TYPE_CHECKING:
    import pandas as pd

BAND = (0.05, 0.95)
"""Quantiles at the ends of the bars, which contain 90 % of the runs."""

_MOST_LINES = 6
_LINE_SHIFT = 0.06  # between two lines over words, so that bars do not overlap
_SHADES = 'viridis'
_DRAWN = (
    'disagreement', 'settling_time', 'least_separation', 'communications', 'position_error',
    'distance_error', 'tracking_error',
)  # fmt: skip


def spread(values: pd.Series, by: pd.Series) -> pd.DataFrame:
    """Return low, middle and high end of a band of values, for each value of a name.

    Values may be inf, so the ends are those of runs, without interpolation.
    """
    return values.groupby(by, sort=False).agg(
        low=lambda part: part.quantile(BAND[0], interpolation='nearest'),
        middle='median',
        high=lambda part: part.quantile(BAND[1], interpolation='nearest'),
    )


def draw_lines(picture: Figure, study: Study, metric: str, by: str) -> None:
    """Draw a metric over a name: medians with bars; a line per value of a second name."""
    picture.set_size_inches(8.0, 5.0)
    words, unit = _words_and_unit(metric)
    label = f'{words} ({unit})' if unit else words
    axes = picture.add_subplot(title=words[0].upper() + words[1:], ylabel=label)
    numbers = study.numbers(metric)
    values, places, is_scale = _axis(axes, study.table[by])
    split = _second(study, by)
    lines = [*study.table.groupby(split, sort=False)] if split else [('', study.table)]
    colours = colormaps[_SHADES](np.linspace(0.0, 0.85, len(lines)))
    medians: list[Any] = []
    for number, (colour, (value, rows)) in enumerate(zip(colours, lines, strict=True)):
        shift = 0 if is_scale else number * _LINE_SHIFT
        band = spread(numbers[rows.index], rows[by]).reindex(values)
        drawn = _draw_medians(axes, [place + shift for place in places], band, colour, is_scale)
        drawn.set_label(as_written(f'{split} = {shown(value)}'))
        medians.append(drawn)
    legend(axes, medians if split else [])
    _note(axes, study, metric)


def _draw_medians(
    axes: Axes, places: Sequence[float], band: pd.DataFrame, colour: Any, is_scale: bool
) -> ErrorbarContainer:
    """Draw medians with bars, and lines between them if they are over numbers."""
    known = band.where(np.isfinite(band))
    bars = np.array([known.middle - known.low, known.high - known.middle])
    look = 'o-' if is_scale else 'o'
    return axes.errorbar(places, band.middle, bars, fmt=look, color=colour)


def _axis(axes: Axes, column: pd.Series) -> tuple[list[Any], list[Any], bool]:
    """Label the axis of a name; return its values, their places, and whether they are numbers."""
    axes.set_xlabel(column.name)
    values = list(column.unique())
    if column.dtype.kind not in 'if':
        axes.set_xticks(range(len(values)), [as_written(shown(value)) for value in values])
        axes.set_xlim(-0.5, len(values) - 0.5)  # also where nothing is drawn
        return values, list(range(len(values))), False
    values.sort()
    if len(values) > 2 and values[0] > 0 and np.ptp(np.diff(np.log(values))) < 1e-6:
        axes.set_xscale('log')
    return values, values, True


def _second(study: Study, by: str) -> str:
    """Return the name with one line per value; '' if there would be too many lines."""
    others = (name for name in study.names if name != by)
    return next((n for n in others if 1 < study.table[n].nunique() <= _MOST_LINES), '')


def _words_and_unit(metric: str) -> tuple[str, str]:
    if metric in COLUMNS:
        return metric.replace('time_2', 'time 2 %').replace('_', ' '), COLUMNS[metric].unit
    return words_and_unit(metric)


def _note(axes: Axes, study: Study, metric: str) -> None:
    """Describe the bars, and count the runs that they leave out."""
    words = ['median and 90 % of the runs']
    if broken := int(study.is_broken.sum()):
        words.append(f'{runs_in_words(broken, "broken")} left out')
    if never := int(np.isinf(study.numbers(metric)).sum()):
        words.append(f'{runs_in_words(never)} never reach{"es" if never == 1 else ""} it')
    axes.annotate(
        '; '.join(words), (0.0, -0.14), xycoords='axes fraction', fontsize=9, color='0.4'
    )


def figure(study: Study, metric: str, by: str | None = None) -> Figure:
    """Return a plot of a study; as `Study.plot`."""
    name = by or next(iter(study.names), '')
    if name not in study.names:
        known = ', '.join(study.names) or 'nothing'
        raise SetcmasError(f"'{name}' is not varied in this study; must be one of {known}")
    with plot_style():
        picture = Picture()
        draw_lines(picture, study, metric, name)
        finish(picture, study.title)
    return picture


def plot(
    study: Study, folder: Path, metrics: Sequence[str] = (), look: PlotOptions | None = None
) -> list[Path]:
    """Write plots of metrics, by default those of the task; return the files."""
    drawn = (
        (f'{metric}_{name}', figure(study, metric, name))
        for metric in metrics or _of_task(study)
        for name in study.names
    )
    return write_figures(drawn, folder, look or PlotOptions())


def _of_task(study: Study) -> Iterator[str]:
    for metric in _DRAWN:
        if metric in study.metrics and study.numbers(metric).nunique() > 1:
            yield metric
