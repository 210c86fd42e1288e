"""Plots of a study: medians with bands, maps, shares of success, trade-offs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.looks.formats import PALETTES
from setcmas_tools.plots.looks.look import PlotLook, check_style
from setcmas_tools.plots.looks.style import finish, plot_style, save_in
from setcmas_tools.plots.plot import Picture
from setcmas_tools.studies.folder import written
from setcmas_tools.studies.groups import median
from setcmas_tools.studies.panels import SUCCESS, draw_lines, draw_map, draw_points, draw_tradeoff
from setcmas_tools.studies.study import Study

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
        raise SetcmasError('a plot of a study is by one name that is varied, or by two for a map')
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
    study: Study, folder: Path, metrics: Sequence[str] = (), look: PlotLook | None = None
) -> list[Path]:
    """Write the plots of a study.

    Args:
        study: The study.
        folder: Where they go.
        metrics: What is drawn; by default what tells most of the task.
        look: How they look.

    Returns:
        The files.

    Raises:
        SetcmasError: There is no such metric, or the plots cannot be written.
    """
    chosen = look or PlotLook()
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
    drawn = list(metrics) or [name for name in _DRAWN if _varies(study, name)]
    drawn += [SUCCESS] if study.plan.info.success else []
    listed = [name for name in study.names if name not in study.plan.cases.draws]
    for metric in drawn:
        yield from ((metric, [n]) for n in study.names if n in listed or metric != SUCCESS)
        for pair in combinations(listed, 2):
            if all(len(list(study.groups(name))) > 2 for name in pair):
                yield metric, list(pair)
    triggered = study.plan.info.parameters['event_triggered'] or 'event_triggered' in study.names
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
