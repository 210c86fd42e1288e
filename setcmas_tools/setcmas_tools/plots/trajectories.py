"""The trajectories of a fleet in the plane, with references and drawings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import MarkerStyle
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.palettes import Colour, plot_colour
from setcmas_tools.plots.reference_lines import draw_references, line_width
from setcmas_tools.plots.style import drawn_robots, edge_effects, legend, line_handles, line_look
from setcmas_tools.run.fleet_motion import FleetTable, gaps
from setcmas_tools.run.run import Run, arena_of, obstacles_of, symbols_of
from setcmas_tools.run.run_records import Drawing, DrawnOverTime

MOST_NUMBERS = 20
"""Fleets of more robots are drawn without their numbers."""

_NUMBER_POINTS = 11.0  # from a start to its robot's number
_STILL_M = 0.05
_NEAR = 0.005  # share of the range of all curves
_DASH = 4.0  # in widths of the line


Curve = tuple[Floats, Floats]
"""Times in s, and values, shape (K,) each."""


def with_gaps(track: FleetTable, *columns: Floats) -> list[Floats]:
    """Return columns of one robot with a NaN in each gap, which breaks lines."""
    breaks = np.flatnonzero(gaps(track)) + 1
    return [np.insert(column, breaks, np.nan) for column in columns]


def finite_rows(table: FleetTable, *names: str) -> FleetTable:
    """Return the rows with finite values in the named columns."""
    columns = np.array([getattr(table, name) for name in names])
    return table.rows(np.isfinite(columns).all(axis=0))


def draw_robot_lines(
    axes: Axes, table: FleetTable, name: str, change: Callable[[Floats], Floats] | None = None
) -> None:
    """Draw one column of a table over time, with a line for each of `drawn_robots`.

    `change` is applied to the values of each robot first.
    """
    curves, robots = {}, table.robots
    for robot in drawn_robots(robots):
        rows = finite_rows(table.of(robot), name)
        values = getattr(rows, name)
        t, values = with_gaps(rows, rows.t, change(values) if change else values)
        curves[robot] = t, values
    draw_curves(axes, curves, len(robots))


def draw_curves(axes: Axes, curves: Mapping[int, Curve], nb_robots: int) -> None:
    """Draw curves of some robots of a fleet; coinciding ones alternate in dashes."""
    known = np.concatenate([values for _, values in curves.values()])
    near = _NEAR * float(np.ptp(known[np.isfinite(known)])) if np.isfinite(known).any() else 0.0
    groups: list[list[int]] = []
    for robot, curve in curves.items():
        same = [group for group in groups if _coincide(curves[group[0]], curve, near)]
        if same:
            same[0].append(robot)
        else:
            groups.append([robot])
    dashes: dict[int, dict[str, Any]] = {}
    for group in groups:
        for place, robot in enumerate(group if len(group) > 1 else []):
            off = _DASH * (len(group) - 1)
            dashes[robot] = {'linestyle': (off + _DASH - _DASH * place, (_DASH, off))}
    for robot, curve in curves.items():
        axes.plot(*curve, **line_look(robot, nb_robots) | dashes.get(robot, {}))


def _coincide(one: Curve, other: Curve, near: float) -> bool:
    """Return whether two curves are nowhere farther apart than `near`."""
    (t, values), (u, others) = one, other
    if len(t) < 2 or len(u) < 2:
        return False
    return float(np.nan_to_num(np.abs(np.interp(t, u, others) - values)).max()) <= near


_ANGLES = np.linspace(0.0, 2 * np.pi, 32, endpoint=False)
_CIRCLE = 0.5 * np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])


class DrawnPlane:
    """Drawings of a run's scripts as discs in a plane.

    Attributes:
        handles: Entries for the legend.
        markers: Artist of drawings that replace earlier ones.
        trails: Artist of drawings that stay.
    """

    def __init__(self, axes: Axes, run: Run) -> None:
        """Fit the plane to all drawings of the run; `show` makes them visible."""
        self._drawn = DrawnOverTime(run.drawings)
        self.trails = PolyCollection([], linewidths=0, zorder=1.8)
        self.markers = PolyCollection([], linewidths=0, zorder=2.5)
        for artist in (self.trails, self.markers):
            axes.add_collection(artist, autolim=False)
        self.handles: list[Line2D] = []
        if self._drawn.shown:
            axes.update_datalim([(d.sphere.x, d.sphere.y) for d in self._drawn.shown])
            look: dict[str, Any] = {'linestyle': '', 'marker': 'o', 'markeredgewidth': 0}
            look['color'] = _shown(*self._drawn.shown[-1].sphere.colour, 1.0)
            self.handles = [Line2D([], [], label='drawn by the script', **look)]

    def show(self, t: float) -> None:
        """Show the markers and trails at a time in s."""
        _fill(self.markers, self._drawn.markers(t))
        _fill(self.trails, self._drawn.trails(t))


def _fill(artist: PolyCollection, drawings: Sequence[Drawing]) -> None:
    spheres = [drawing.sphere for drawing in drawings]
    artist.set_verts([(s.x, s.y) + s.diameter * _CIRCLE for s in spheres])
    artist.set_facecolor([_shown(*s.colour, s.alpha) for s in spheres])


def _shown(*colour: float) -> tuple[float, float, float, float]:
    """Return a script's colour with each part limited to 0 to 1."""
    red, green, blue, alpha = np.clip(colour, 0.0, 1.0).tolist()
    return red, green, blue, alpha


def draw_world(axes: Axes, run: Run) -> list[Artist]:
    """Draw arena and obstacles of a run; return the entries for the legend."""
    handles: list[Artist] = []
    if arena := arena_of(run):
        x = [arena.xmin, arena.xmax, arena.xmax, arena.xmin, arena.xmin]
        y = [arena.ymin, arena.ymin, arena.ymax, arena.ymax, arena.ymin]
        look: dict[str, Any] = {'color': '0.55', 'linewidth': line_width(), 'zorder': 1.5}
        handles += axes.plot(x, y, label='arena', **look)
    obstacles = obstacles_of(run)
    shapes: list[Patch] = [Circle((x, y), radius) for x, y, radius in obstacles.discs]
    shapes += [Polygon(one.corners) for one in obstacles.polygons]
    for shape in shapes:
        shape.set(facecolor='0.8', edgecolor='0.55', linewidth=line_width(), zorder=1.4)
        axes.add_patch(shape)
    if shapes:
        handles.append(Patch(label='obstacle', facecolor='0.8', edgecolor='0.55'))
    return handles


def closed(corners: Floats) -> Outline:
    """Return an outline as a path."""
    return Outline(np.vstack([corners, corners[:1]]), closed=True)


_SMALLEST_SPAN_M = 1.0


def draw_trajectories(figure: Figure, run: Run) -> None:
    """Draw each robot's path with its start (ring) and its end (dart along its heading)."""
    figure.set_size_inches(8.0, 6.4)
    axes = figure.add_subplot()
    table, robots = run.table, run.robots
    size = rcParams['lines.markersize'] * (1.5 if len(robots) < 12 else 1.1)
    looks = symbols_of(run)
    for robot in drawn_robots(robots):
        _draw_path(axes, table.of(robot), robot, len(robots), size)
        if len(robots) <= MOST_NUMBERS:
            _number(axes, table.of(robot), robot)
        _draw_end(axes, table.of(robot), plot_colour(robot, len(robots)), size, looks[robot])
    drawn = DrawnPlane(axes, run)
    drawn.show(np.inf)
    marks = draw_references(axes, run) + draw_world(axes, run) + drawn.handles
    axes.set_title('Trajectories')
    fit_plane(axes, table)
    legend(axes, [*line_handles(robots), *_end_handles(looks[robots[0]]), *marks])


def _draw_path(axes: Axes, path: FleetTable, robot: int, nb_robots: int, size: float) -> None:
    path = finite_rows(path, 'x', 'y', 'theta')
    if not len(path.t):
        return
    x, y = with_gaps(path, path.x, path.y)
    axes.plot(x, y, **line_look(robot, nb_robots))
    colour = plot_colour(robot, nb_robots)
    axes.plot(
        path.x[:1], path.y[:1], marker='o', markersize=size * 0.8, markerfacecolor='white',
        markeredgecolor=colour, markeredgewidth=size / 5, linestyle='', zorder=3,
        path_effects=edge_effects(colour, size / 5),
    )  # fmt: skip


def _draw_end(axes: Axes, path: FleetTable, colour: Colour, size: float, corners: Floats) -> None:
    path = finite_rows(path, 'x', 'y', 'theta')
    heading = Affine2D().rotate(math.fmod(path.theta[-1], math.tau)) if len(path.t) else None
    axes.plot(
        path.x[-1:], path.y[-1:], marker=MarkerStyle(closed(corners), transform=heading),
        markersize=size * float(np.abs(corners).max()), markerfacecolor=colour, zorder=4,
        markeredgecolor='0.15', markeredgewidth=size / 11, linestyle='',
    )  # fmt: skip


def _number(axes: Axes, path: FleetTable, robot: int) -> None:
    """Write a robot's number beside its start, on the side that its path leaves free."""
    path = finite_rows(path, 'x', 'y')
    for x, y in zip(path.x[:1], path.y[:1], strict=True):
        away = np.array([x - path.x.mean(), y - path.y.mean()])
        length = float(np.hypot(*away))
        offset = _NUMBER_POINTS * (away / length if length > _STILL_M else np.sqrt([0.5, 0.5]))
        axes.annotate(
            str(robot), (x, y), tuple(offset), textcoords='offset points', zorder=5,
            ha='center', va='center', fontsize=rcParams['legend.fontsize'],
        )  # fmt: skip


def fit_plane(axes: Axes, table: FleetTable) -> None:
    """Show all positions of a fleet with equal scales, and a plane of some size at least.

    A robot that hardly moves does not fill the plot with its noise.
    """
    rows = finite_rows(table, 'x', 'y')
    if len(rows.t):
        axes.update_datalim(np.column_stack([rows.x, rows.y]))
    middle = (axes.dataLim.p0 + axes.dataLim.p1) / 2
    axes.update_datalim([middle - _SMALLEST_SPAN_M / 2, middle + _SMALLEST_SPAN_M / 2])
    axes.set(xlabel='x (m)', ylabel='y (m)')
    axes.margins(0.06)
    axes.autoscale_view()
    axes.set_aspect('equal', adjustable='datalim')


def _end_handles(outline: Floats) -> list[Line2D]:
    size = 1.3 * rcParams['lines.markersize']
    look: dict[str, Any] = {
        'linestyle': '',
        'markersize': size,
        'markeredgecolor': '0.15',
        'markeredgewidth': size / 11,
    }
    return [
        Line2D([], [], label='start', marker='o', markerfacecolor='white', **look),
        Line2D(
            [], [], label='end, heading', marker=MarkerStyle(closed(outline)), color='0.6', **look
        ),
    ]
