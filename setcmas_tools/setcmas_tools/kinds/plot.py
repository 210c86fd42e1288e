"""Plots: functions that draw a run into a figure, found by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from setcmas_simu.doors import Door, MisfitError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from setcmas_tools.run.run import Run

Plot = Callable[['Figure', 'Run'], None]
"""Draws a run into an empty figure, with the plot's name as the title of its first axes."""

Applies = Callable[['Run'], bool]


def applies_to(condition: Applies) -> Callable[[Plot], Plot]:
    """Return a decorator of plots that suit only the runs that fulfil a condition."""

    def decorate(plot: Plot) -> Plot:
        plot.applies = condition  # type: ignore[attr-defined]
        return plot

    return decorate


def suits(plot: Plot, run: Run) -> bool:
    """Return whether a plot suits a run."""
    condition: Any = getattr(plot, 'applies', None)
    return condition is None or bool(condition(run))


def _plot(thing: object) -> Plot:
    if not callable(thing):
        raise MisfitError(f'it is a {type(thing).__name__}; it must be draw(figure, run)')
    return thing


PLOTS = Door('setcmas.plots', 'plot', _plot)
"""The plots that are installed."""
