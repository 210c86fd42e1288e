"""Plot of a ladder for a slide: the paths on each rung, over those of the rung before."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from setcmas_tools.compare.ladder import Rung
from setcmas_tools.plots.style import as_written, line_look
from setcmas_tools.run.run import Run

_SLIDE_IN = (12.0, 6.75)
_DOTS = 20  # along a path, about


def ladder_figure(rungs: list[Rung]) -> Figure:
    """Return the paths on each rung, with its end, rate and distance from the rung before.

    Dots along the paths show where robots are at equal times. Call and save within `plot_style`.
    """
    figure = Figure(figsize=_SLIDE_IN)
    panels = figure.subplots(2, math.ceil(len(rungs) / 2)).ravel()
    recorded = rungs[-1].run
    apart = _between_dots(float(recorded.counted.t[-1]))
    largest = max(rung.step or 0.0 for rung in rungs)
    for number, rung in enumerate(rungs):
        axes = panels[number]
        if number:
            _draw_paths(axes, rungs[number - 1].run, apart, is_before=True)
        _draw_paths(axes, rung.run, apart)
        weight = 'bold' if rung.step == largest else 'normal'
        axes.set_title(f'{number + 1}  {rung.name}', fontsize='medium', fontweight=weight)
        axes.set_xlabel(_caption(rung), fontsize='small', fontweight=weight)
        axes.set(aspect='equal', **_borders(recorded))
        axes.tick_params(labelsize='x-small')
    for axes in panels[len(rungs) :]:
        axes.set_axis_off()
    figure.suptitle(as_written(f'{recorded.title}: from single integrators to the run'))
    legend = f'grey: the rung before; dots: every {apart:g} s; bold: the largest step'
    figure.supxlabel(legend, fontsize='small', color='0.4')
    return figure


def _borders(run: Run) -> dict[str, tuple[float, float]]:
    """Return limits in m of both axes for a square around the paths of a run."""
    table = run.counted
    sides = [(np.nanmin(values), np.nanmax(values)) for values in (table.x, table.y)]
    half = 0.62 * max(1.0, *(high - low for low, high in sides))
    middles = [(low + high) / 2 for low, high in sides]
    return {f'{axis}lim': (m - half, m + half) for axis, m in zip('xy', middles, strict=True)}


def _between_dots(duration: float) -> float:
    """Return a round time in s, so that a path has about `_DOTS` dots."""
    least = duration / _DOTS
    size = 10.0 ** math.floor(math.log10(least))
    return next(size * step for step in (1, 2, 5, 10) if size * step >= least - 1e-9)


def _draw_paths(axes: Axes, run: Run, apart: float, is_before: bool = False) -> None:
    grid = run.counted_grid
    every = np.abs(grid.t / apart - np.round(grid.t / apart)) < 1e-6
    for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True):
        look = line_look(robot, len(grid.robots))
        if is_before:
            axes.plot(x, y, color='0.85', linewidth=5.0, zorder=1)
            axes.plot(x[every], y[every], 'o', color='0.65', ms=5.5, zorder=1.1)
        else:
            axes.plot(x, y, **look)
            axes.plot(x[every], y[every], 'o', color=look['color'], mec='0.15', mew=0.4, ms=3.0)
            axes.plot(x[:1], y[:1], 'o', mfc='white', mec=look['color'], ms=5.0, zorder=3)


def _caption(rung: Rung) -> str:
    x, y = (round(value, 2) + 0.0 for value in rung.end)
    rate = rung.error_and_rate[1]
    text = f'end ({x:.2f}, {y:.2f}) m' + ('' if rate is None else f', rate {rate:.3g} 1/s')
    return text if rung.step is None else f'{text}\n{rung.step:.3f} m (RMS) from the rung before'
