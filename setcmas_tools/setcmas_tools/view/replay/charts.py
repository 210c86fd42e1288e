"""Charts below the scene: what is measured of a run over time."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import viser
from viser import uplot

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import plot_colour
from setcmas_tools.replay.curves import FLEET, Curve

_MOST_POINTS = 1500
_HEIGHT_PX = 118
_DARK = 'rgb(38,38,38)'
_CURSOR = (
    '<style>.u-over::after{{content:"";position:absolute;top:0;bottom:0;left:{:.3f}%;'
    'border-left:1.5px solid rgb(37,99,235);pointer-events:none}}</style>'
)


def add_charts(gui: viser.GuiApi, curves: Sequence[Curve], span: tuple[float, float]) -> None:
    """Add a tab for each chart.

    Args:
        gui: Of the page.
        curves: What is charted; those of one name share a chart, the later ones dashed.
        span: Begin and end of all charts in s.
    """
    tabs = gui.add_tab_group()
    for name in dict.fromkeys(curve.name for curve in curves):
        with tabs.add_tab(name):
            _add_chart(gui, [curve for curve in curves if curve.name == name], span)


def cursor_style(share: float) -> str:
    """Return the HTML that puts the cursor of all charts at a share of their width."""
    return _CURSOR.format(100 * share)


def _add_chart(gui: viser.GuiApi, curves: Sequence[Curve], span: tuple[float, float]) -> None:
    t, *rows = _sampled(curves, span)
    series = [uplot.Series(label='t (s)')]
    for number, curve in enumerate(curves):
        for robot in curve.values:
            series.append(_series(robot, dashed=number > 0, width=1.5 if robot else 2.0))
    gui.add_uplot(
        (t, *rows),
        tuple(series),
        scales={'x': uplot.Scale(time=False, range=span)},
        axes=(
            uplot.Axis(size=26),
            uplot.Axis(label=curves[0].unit, labelSize=18, size=42),
        ),
        legend=uplot.Legend(show=False),
        cursor=uplot.Cursor(drag=uplot.Cursor_Drag(x=False, y=False)),
        padding=(6, 10, 0, 0),
        height=_HEIGHT_PX,
    )


def _series(robot: int, dashed: bool, width: float) -> uplot.Series:
    colour = _DARK
    if robot != FLEET:
        red, green, blue = (round(255 * part) for part in plot_colour(robot))
        colour = f'rgb({red},{green},{blue})'
    label = f'robot {robot}' if robot != FLEET else 'fleet'
    points = uplot.Series_Points(show=False)
    series = uplot.Series(label=label, stroke=colour, width=width, points=points)
    if dashed:
        series['dash'] = (6.0, 4.0)
    return series


def _sampled(curves: Sequence[Curve], span: tuple[float, float]) -> list[Floats]:
    """Return times and the values of each line there; a chart needs no more than it has dots."""
    times = max((curve.t for curve in curves), key=len)
    step = max(1, math.ceil(len(times) / _MOST_POINTS))
    t = times[::step] if len(times) else np.array(span)
    rows = [np.interp(t, c.t, values) for c in curves for values in c.values.values()]
    return [t, *rows]
