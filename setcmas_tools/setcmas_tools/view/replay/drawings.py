"""What stood and what scripts drew on the ground of a run, as shapes of the scene."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from setcmas_simu.arrays import Floats
from setcmas_tools.plots.trajectories import draw_references
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.run.law_output import MARKER, Drawing
from setcmas_tools.run.run import Run, arena_of, obstacles_of
from setcmas_tools.view.model.marker_shapes import LINES, Shape
from setcmas_tools.view.model.marker_store import MarkerStore

_MOST_SPHERES = 5000  # of trails: the newest
_LINE_M = 0.03
_ABOVE_M = 0.02
_OBSTACLE_M = 0.2
_GREY = (0.5, 0.5, 0.5)
_MARK_M = 0.15  # diameter of what a plot marks with a symbol


class ReplayedDrawings:
    """Puts shapes into a store as they were at a time."""

    def __init__(self, history: RunHistory, store: MarkerStore) -> None:
        """Put what stands there: arena, obstacles, references of the task."""
        self._history, self._store = history, store
        self._shown: tuple[int, ...] = ()
        for number, found in enumerate(_standing(history.run)):
            store.put(('standing', '', number), found)

    def show(self, t: float) -> None:
        """Put what scripts had drawn at a time in s, if it is other than before."""
        drawings = self._history.drawings(t)
        markers = [drawing for drawing in drawings if drawing.kind == MARKER]
        shown = (len(drawings), *map(id, markers))
        if shown == self._shown:
            return
        self._shown = shown
        trails = [drawing for drawing in drawings if drawing.kind != MARKER]
        rows = _spheres([*trails[-_MOST_SPHERES:], *markers])
        self._store.put(('drawn', '', 0), Shape('sphere', 0, rows) if len(rows) else None)


def _spheres(drawings: Sequence[Drawing]) -> Floats:
    """Return rows of `Shape` for spheres."""
    rows = np.zeros((len(drawings), 14))
    rows[:, 3] = 1.0
    for row, (*_, sphere) in zip(rows, drawings, strict=True):
        row[:3] = sphere[:3]
        row[7:10] = abs(sphere.diameter)
        row[10:] = *sphere.colour, sphere.alpha
    rows[:, 10:] = np.clip(rows[:, 10:], 0.0, 1.0)
    return rows


def _standing(run: Run) -> Iterable[Shape]:
    obstacles, arena = obstacles_of(run), arena_of(run)
    for x, y, radius in obstacles.discs:
        sizes = (2 * radius, 2 * radius, _OBSTACLE_M)
        row = [x, y, 0.5 * _OBSTACLE_M, 1, 0, 0, 0, *sizes, *_GREY, 1.0]
        yield Shape('cylinder', 0, np.array([row]))
    for polygon in obstacles.polygons:
        yield from _line(np.array([*polygon.corners, polygon.corners[0]]), _GREY)
    if arena:
        xmin, xmax, ymin, ymax = arena
        corners = [(xmin, ymin), (xmax, ymin), (xmax, ymax), (xmin, ymax), (xmin, ymin)]
        yield from _line(np.array(corners), _GREY)
    axes = Figure().add_subplot()
    draw_references('film', axes, run)
    yield from _drawn_on(axes)


def _drawn_on(axes: Axes) -> Iterable[Shape]:
    """Yield what a task has drawn into a plot of the plane, on the ground: lines and marks."""
    for line in axes.lines:
        points, colour = np.array(line.get_xydata(), dtype=float), to_rgb(line.get_color())
        if line.get_linestyle() not in ('None', 'none', '', ' '):
            yield from _line(points, colour)
        elif len(points):
            mark = [0, 0, _ABOVE_M, 1, 0, 0, 0, _MARK_M, _MARK_M, 0.5 * _ABOVE_M, *_GREY, 1]
            rows = np.tile(mark, (len(points), 1))
            rows[:, :2] = points
            yield Shape('cylinder', 0, rows)
    for patch in axes.patches:
        path = patch.get_path().transformed(patch.get_patch_transform())
        for outline in path.to_polygons():
            yield from _line(np.array(outline), to_rgb(patch.get_edgecolor()))


def _line(points: Floats, colour: Sequence[float]) -> Iterable[Shape]:
    """Yield a line on the ground through points, shape (K, 2)."""
    places = np.column_stack([points, np.full(len(points), _ABOVE_M)])
    places = places[np.isfinite(places).all(axis=1)]
    if len(places) > 1:
        colours = np.tile([*colour, *colour], (len(places) - 1, 1))
        rows = np.column_stack([places[:-1], places[1:], colours])
        yield Shape(LINES, 0, rows, thickness=_LINE_M)
