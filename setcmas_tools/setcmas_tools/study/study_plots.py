"""Plots of a study: medians with bands, maps, success rates, trade-offs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.palettes import PALETTES
from setcmas_tools.measures.metric import words_and_unit
from setcmas_tools.plots.plot import Picture
from setcmas_tools.plots.plot_settings import PlotSettings, check_style
from setcmas_tools.plots.style import finish, legend, plot_style, save_in
from setcmas_tools.study.study import Study, median, quantiles, runs_in_words, shown
from setcmas_tools.study.study_columns import COLUMNS, predicted
from setcmas_tools.study.study_folder import written
from setcmas_tools.study.success import CONFIDENCE, share_of

SUCCESS = 'success'
"""Pseudo-metric of plots: the success rate."""

BAND = (0.05, 0.5, 0.95)
"""Quantiles of a band with 90 % of the runs, and the median."""

_MOST_LINES = 6
_MARGIN = 0.04
_BETWEEN_BARS = 0.06  # of two lines at the same value
_SHADES = 'viridis'
_THEORY = 'predicted'


def draw_lines(picture: Figure, study: Study, metric: str, by: str, success: str | None) -> None:
    """Draw a metric over a name: the median with a band, or the success rate."""
    picture.set_size_inches(8.0, 5.0)
    axes = picture.add_subplot(title=_title(metric), ylabel=_label(metric))
    places = _axis(axes, study, by)
    split = _second(study, by)
    colours = _colours(len(list(study.groups(*split))))
    for colour, line in zip(colours, study.groups(*split), strict=True):
        inside = set(line.rows)
        rows = [[row for row in group.rows if row in inside] for group in study.groups(by)]
        low, middle, high = np.array([_spread(study, metric, one, success) for one in rows]).T
        is_scale, name = _is_scale(study, by), str(line)
        if predicted(metric) in study.metrics:
            name = name or 'measured'
            theory = [median(study.numbers(predicted(metric))[one]) for one in rows]
            look = '-' if is_scale else '_'
            axes.plot(places, theory, look, color='0.8', lw=6, ms=30, mew=6, label=_THEORY)
        if is_scale:
            axes.plot(places, middle, 'o-', color=colour, label=name)
            axes.fill_between(places, low, high, color=colour, alpha=0.18, linewidth=0)
        else:
            bars = _bars(low, middle, high)
            axes.errorbar(places, middle, bars, None, 'o', color=colour, label=name)
            places = [place + _BETWEEN_BARS for place in places]
    if metric == SUCCESS:
        axes.set_ylim(-0.02, 1.02)
    handles = {one.get_label(): one for one in axes.get_legend_handles_labels()[0]}
    legend(axes, sorted(handles.values(), key=lambda one: one.get_label() == _THEORY))
    _note(axes, study, metric)


def draw_points(picture: Figure, study: Study, metric: str, by: str) -> None:
    """Draw a metric over a random number of each run, a point per run."""
    picture.set_size_inches(8.0, 5.0)
    axes = picture.add_subplot(title=_title(metric), xlabel=by, ylabel=_label(metric))
    split = _second(study, by)
    values, numbers = study[by], study.numbers(metric)
    colours = _colours(len(list(study.groups(*split))))
    for colour, group in zip(colours, study.groups(*split), strict=True):
        rows = list(group.rows)
        axes.plot(values[rows], numbers[rows], '.', color=colour, label=str(group))
    legend(axes, axes.get_legend_handles_labels()[0])
    _note(axes, study, metric, 'one point per run')


def _spread(study: Study, metric: str, rows: Sequence[int], success: str | None) -> Any:
    """Return lower end, middle and upper end of the band for some runs."""
    if metric == SUCCESS:
        successes = study.successes(success)
        share, low, high = share_of([successes[row] for row in rows])
        return low, share, high
    return quantiles(study.numbers(metric)[list(rows)], *BAND)


def draw_map(
    picture: Figure, study: Study, metric: str, by: tuple[str, str], success: str | None
) -> None:
    """Draw the median of a metric, or the success rate, over two names."""
    picture.set_size_inches(8.0, 6.0)
    axes = picture.add_subplot(title=_title(metric))
    along, up = ([group.values[name] for group in study.groups(name)] for name in by)
    values = np.full((len(up), len(along)), np.nan)
    for group in study.groups(*by):
        place = up.index(group.values[by[1]]), along.index(group.values[by[0]])
        values[place] = _spread(study, metric, group.rows, success)[1]
    image = axes.pcolormesh(
        np.where(np.isfinite(values), values, np.nan), cmap=_SHADES, edgecolors='white'
    )
    picture.colorbar(image, ax=axes, label=_label(metric))
    for axis, name, known in ((axes.xaxis, by[0], along), (axes.yaxis, by[1], up)):
        axis.set_ticks(np.arange(len(known)) + 0.5, [shown(value) for value in known])
        axis.set_label_text(name)
    axes.grid(False)
    _note(axes, study, metric, 'median of the runs')


def draw_tradeoff(picture: Figure, study: Study, by: str) -> None:
    """Draw median communications over median settling time, a point per value."""
    picture.set_size_inches(8.0, 5.0)
    axes = picture.add_subplot(
        title='Trade-off', xlabel=_label('settling_time'), ylabel=_label('communications')
    )
    groups = list(study.groups(by))
    points = np.array(
        [
            [quantiles(study.numbers(name)[list(group.rows)], *BAND) for group in groups]
            for name in ('settling_time', 'communications')
        ]
    )
    x, y = points[:, :, 1]
    seen = np.isfinite(points[:, :, 1]).all(axis=0)
    if not seen.any():
        raise SetcmasError(
            f'no trade-off to draw: at each value of {by}, fewer than half of the runs settle '
            'and report their communications'
        )
    spread = [_bars(*one.T) for one in points]
    if _is_scale(study, by):
        axes.plot(x[seen], y[seen], '-', color='0.7', zorder=1)
    for index, (group, colour) in enumerate(zip(groups, _colours(len(groups)), strict=True)):
        if seen[index]:
            bars = {'xerr': spread[0][:, [index]], 'yerr': spread[1][:, [index]]}
            axes.errorbar(x[index], y[index], fmt='o', color=colour, label=str(group), **bars)
    legend(axes, axes.get_legend_handles_labels()[0])
    _note(axes, study, 'settling_time')


def _axis(axes: Axes, study: Study, name: str) -> Any:
    """Label the axis of a name, and return the positions of its values."""
    values = [group.values[name] for group in study.groups(name)]
    axes.set_xlabel(name)
    if not _is_scale(study, name):
        axes.set_xticks(range(len(values)), [shown(value) for value in values])
        axes.set_xlim(-0.5, len(values) - 0.5)  # also where nothing is drawn
        return list(range(len(values)))
    low, high = min(values), max(values)
    if len(values) > 2 and low > 0 and np.ptp(np.diff(np.log(values))) < 1e-6:
        axes.set_xscale('log')
        margin = (high / low) ** _MARGIN
        axes.set_xlim(low / margin, high * margin)
    elif high > low:  # also where a line breaks off since its values are never reached
        axes.set_xlim(low - _MARGIN * (high - low), high + _MARGIN * (high - low))
    return values


def _is_scale(study: Study, name: str) -> bool:
    """Return whether the values of a name are numbers, so that lines may connect them."""
    return all(isinstance(group.values[name], float) for group in study.groups(name))


def _bars(*band: Any) -> Any:
    """Return the distances of the ends from the middle; NaN for values never reached."""
    low, middle, high = np.where(np.isfinite(band), band, np.nan)
    return np.abs([low - middle, high - middle])


def _second(study: Study, by: str) -> list[str]:
    """Return the name with one line per value; none if there would be too many lines."""
    others = [name for name in study.names if name not in (by, *study.plan.cases.draws)]
    return next(
        ([name] for name in others if 1 < len(list(study.groups(name))) <= _MOST_LINES), []
    )


def _colours(count: int) -> list[Any]:
    return list(colormaps[_SHADES](np.linspace(0.0, 0.85, max(count, 1))))


def _title(metric: str) -> str:
    words, _ = _words_and_unit(metric)
    return words[0].upper() + words[1:]


def _label(metric: str) -> str:
    if metric == SUCCESS:
        return f'share of successes ({100 * CONFIDENCE:.0f} % Wilson interval)'
    words, unit = _words_and_unit(metric)
    return f'{words} ({unit})' if unit else words


def _words_and_unit(metric: str) -> tuple[str, str]:
    if metric in COLUMNS:
        return metric.replace('time_2', 'time 2 %').replace('_', ' '), COLUMNS[metric].unit
    return words_and_unit(metric)


def _note(
    axes: Axes, study: Study, metric: str, band: str = 'median and 90 % of the runs'
) -> None:
    """Describe the band, and count the runs that it leaves out."""
    words = [] if metric == SUCCESS else [band]
    broken = int(np.sum(~study.measured))
    if broken and metric != SUCCESS:
        words.append(f'{runs_in_words(broken, "broken")} left out')
    if metric in study.metrics and (never := int(np.isinf(study.numbers(metric)).sum())):
        words.append(f'{runs_in_words(never)} never reach{"es" if never == 1 else ""} it')
    axes.annotate(
        '; '.join(words), (0.0, -0.14), xycoords='axes fraction', fontsize=9, color='0.4'
    )


TRADEOFF = 'tradeoff'
"""The plot of communications against settling time."""


_DRAWN = (
    'disagreement', 'settling_time', 'least_separation', 'communications', 'position_error',
    'distance_error', 'tracking_error',
)  # fmt: skip


def figure(
    study: Study,
    metric: str,
    by: str | Sequence[str] | None = None,
    success: str | None = None,
    palette: str = PALETTES[0],
    paper: str | None = None,
) -> Figure:
    """Return a plot of a study; as `Study.plot`.

    Raises:
        SetcmasError: There is no such column or style, or nothing is varied.
    """
    check_style(palette, paper)
    names = [by] if isinstance(by, str) else list(by or study.names[:1])
    if not 1 <= len(names) <= 2:
        raise SetcmasError('a plot of a study needs one varied name, or two for a map')
    with plot_style(palette, paper):
        picture = Picture()
        if metric == TRADEOFF:
            draw_tradeoff(picture, study, names[0])
        elif len(names) == 1 and names[0] in study.plan.cases.draws:
            draw_points(picture, study, metric, names[0])
        elif len(names) == 2:
            draw_map(picture, study, metric, (names[0], names[1]), success)
        else:
            draw_lines(picture, study, metric, names[0], success)
        finish(picture, study.title)
    return picture


def plot(
    study: Study, folder: Path, metrics: Sequence[str] = (), look: PlotSettings | None = None
) -> list[Path]:
    """Write the plots of a study.

    Args:
        study: The study.
        folder: Their folder.
        metrics: Metrics to plot; by default those of the task.
        look: Formats and style.

    Returns:
        The files.

    Raises:
        SetcmasError: There is no such metric, or the plots cannot be written.
    """
    chosen = look or PlotSettings()
    chosen.check()
    paths: list[Path] = []
    with written(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for metric, names in _plots_of(study, metrics):
            drawn = figure(study, metric, names, palette=chosen.palette, paper=chosen.paper)
            stem = '_'.join([metric, *names])
            with plot_style(chosen.palette, chosen.paper):
                paths += save_in(chosen.formats, drawn, folder / stem)
    return paths


def _plots_of(study: Study, metrics: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    compared = [name for name in study.metrics if predicted(name) in study.metrics]
    drawn = list(metrics) or [n for n in (*_DRAWN, *compared) if _varies(study, n)]
    drawn += [SUCCESS] if study.plan.info.success else []
    listed = [name for name in study.names if name not in study.plan.cases.draws]
    for metric in drawn:
        yield from ((metric, [n]) for n in study.names if n in listed or metric != SUCCESS)
        for pair in combinations(listed, 2):
            if all(len(list(study.groups(name))) > 2 for name in pair):
                yield metric, list(pair)
    triggered = study.plan.info.scenario['event_triggered'] or 'event_triggered' in study.names
    if triggered and 'settling_time' in study.metrics:
        yield from ((TRADEOFF, [name]) for name in listed if _settles(study, name))


def _settles(study: Study, by: str) -> bool:
    """Return whether half of the runs with some value of a name settle."""
    times = study.numbers('settling_time')
    return any(np.isfinite(median(times[list(group.rows)])) for group in study.groups(by))


def _varies(study: Study, metric: str) -> bool:
    if metric not in study.metrics:
        return False
    values = study.numbers(metric)
    return len(np.unique(values[~np.isnan(values)])) > 1
