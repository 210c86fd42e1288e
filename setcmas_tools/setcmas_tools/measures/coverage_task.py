"""The task `coverage`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_ctrl.laws.references import points
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.palettes import plot_colour
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.task import Task
from setcmas_tools.run.fleet_motion import FleetGrid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from setcmas_tools.run.run import Run

_MOST_TIMES, _MOST_M = 200, 1e6
_POINTS, _PIXELS = 60, 400  # along each side of the box


def box(value: Any) -> list[list[float]]:
    """Check that a reference is a box.

    Raises:
        ValueError: It is not; the message says what it must be.
    """
    corners = points(value)
    if len(corners) != 2 or not (np.diff(corners, axis=0) > 0).all() or np.max(corners) > _MOST_M:
        raise ValueError('it must be the corners [[left, bottom], [right, top]] of a box (m)')
    return corners


@dataclass(frozen=True)
class CoverageMetrics(Measured):
    """The cost: the integral over the box of the squared distance to the nearest robot.

    The largest rise is above the lowest cost before, in percent of the cost at the start.
    """

    cost_at_start_m4: float
    cost_at_end_m4: float
    largest_rise_percent: float

    def lines(self) -> list[str]:
        """Return the costs and the largest rise."""
        return [
            f'coverage: cost {self.cost_at_start_m4:.4g} m^4 at the start, '
            f'{self.cost_at_end_m4:.4g} m^4 at the end; it rose by at most '
            f'{self.largest_rise_percent:.2f} %'
        ]


def squared_distances(corners: Floats, places: Floats, count: int) -> Floats:
    """Return squared distances (m^2) of N places (2, N) from count x count points of a box.

    Returns:
        An array of shape (N, count, count), by place, y and x.
    """
    shares = (np.arange(count) + 0.5) / count
    x, y = corners[0, :, None] + np.diff(corners, axis=0).T * shares
    at_x, at_y = places[:, :, None, None]
    squares: Floats = (at_x - x) ** 2 + (at_y - y[:, None]) ** 2
    return squares


def _known(grid: FleetGrid) -> Floats:
    """Return the positions of all robots where they are known, shape (K, 2, N)."""
    places: Floats = np.stack([grid.x.T, grid.y.T], axis=1)
    return places[np.isfinite(places).all(axis=(1, 2))]


def coverage(grid: FleetGrid, corners: Floats) -> CoverageMetrics | None:
    """Return the cost of a coverage in a box (m), from sampled points and times.

    None if the robots are never all known. Source: Cortes, Martinez, Karatas and Bullo, IEEE
    Transactions on Robotics and Automation 20(2), 2004.
    """
    places = _known(grid)
    if not len(places):
        return None
    chosen = np.unique(np.linspace(0, len(places) - 1, _MOST_TIMES).astype(int))
    nearest = [squared_distances(corners, one, _POINTS).min(axis=0) for one in places[chosen]]
    costs = np.mean(nearest, axis=(1, 2)) * np.prod(np.diff(corners, axis=0))
    rise = float(np.max(costs - np.minimum.accumulate(costs)) / costs[0])
    return CoverageMetrics(float(costs[0]), float(costs[-1]), round(100.0 * rise, 2))


class _Coverage(Task):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        return {'coverage': coverage(run.counted_grid, np.array(references['BOX']))}

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        if plot not in ('trajectories', 'film'):
            return []
        (left, bottom), (right, top) = references['BOX']
        places = _known(run.counted_grid)
        if plot == 'trajectories' and len(places):
            _draw_cells(axes, run.counted_grid.robots, places[-1], np.array(references['BOX']))
        x, y = [left, right, right, left, left], [bottom, bottom, top, top, bottom]
        return axes.plot(x, y, label='box', color='0.15', linestyle=':', zorder=1.5)


def _draw_cells(axes: Axes, robots: list[int], places: Floats, corners: Floats) -> None:
    """Colour each point of a box like the robot that is nearest to it."""
    nearest = squared_distances(corners, places, _PIXELS).argmin(axis=0)
    colours = np.array([plot_colour(robot, len(robots)) for robot in robots])
    (left, right), (bottom, top) = corners.T.tolist()
    extent = (left, right, bottom, top)
    axes.imshow(colours[nearest], extent=extent, origin='lower', alpha=0.2, zorder=0.5)


COVERAGE = _Coverage({'BOX': box})
"""The task."""
