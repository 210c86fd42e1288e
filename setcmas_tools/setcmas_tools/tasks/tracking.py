"""The task `tracking`: robots are to follow a point that goes round a circle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_ctrl.task.references import number
from setcmas_simu.arrays import Floats
from setcmas_tools.kinds.metric import Columns, Measured
from setcmas_tools.kinds.task import Errors, Task
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.tasks.errors import rms, rms_by_robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from setcmas_tools.run.run import Run

_CORNERS = 181


@dataclass(frozen=True)
class TrackingMetrics(Measured):
    """RMS distances to the reference, by robot; the last two over all robots."""

    tracking_error_rms_m: dict[int, float]
    tracking_error_rms_second_half_m: dict[int, float]
    fleet_tracking_error_rms_m: float
    fleet_tracking_error_rms_second_half_m: float

    def columns(self) -> Columns:
        """Return the errors of each robot."""
        return {
            'RMS error\n(m)': ('.3f', self.tracking_error_rms_m),
            'RMS 2nd\nhalf (m)': ('.3f', self.tracking_error_rms_second_half_m),
        }

    def lines(self, task: str | None) -> list[str]:
        """Return the errors of the fleet."""
        del task
        return [
            f'tracking: RMS error {self.fleet_tracking_error_rms_m:.3f} m, '
            f'{self.fleet_tracking_error_rms_second_half_m:.3f} m over the second half'
        ]


def tracking_errors(grid: FleetGrid, radius: float, rate: float) -> dict[int, Floats]:
    """Return the distance of each robot to r(t) in m over time; arguments as for `tracking`."""
    reference = radius * np.array([np.cos(rate * grid.t), np.sin(rate * grid.t)])
    return {
        robot: np.hypot(x - reference[0], y - reference[1])
        for robot, x, y in zip(grid.robots, grid.x, grid.y, strict=True)
    }


def tracking(grid: FleetGrid, radius: float, rate: float) -> TrackingMetrics | None:
    """Return the errors to the reference r(t) = R (cos W t, sin W t).

    Source: Siciliano et al., Robotics, 2009, section 11.6.

    Args:
        grid: The fleet's motion.
        radius: R in m.
        rate: W in rad/s.
    """
    errors = tracking_errors(grid, radius, rate)
    whole, late = rms_by_robot(grid.t, errors, 0.0), rms_by_robot(grid.t, errors, 0.5)
    if not late:
        return None
    return TrackingMetrics(whole, late, rms(list(whole.values())), rms(list(late.values())))


class _Tracking(Task):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        return {'tracking': tracking(run.counted_grid, references['R'], references['W'])}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors:
        values = tracking_errors(run.counted_grid, references['R'], references['W'])
        return Errors('Tracking error', 'distance to the reference (m)', values)

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        from setcmas_tools.plots.references import DOTTED, line_width

        del run
        if plot not in ('trajectories', 'film'):
            return []
        angles = np.linspace(0.0, 2 * np.pi, _CORNERS)
        x, y = references['R'] * np.cos(angles), references['R'] * np.sin(angles)
        return axes.plot(x, y, label='reference', linewidth=1.5 * line_width(), **DOTTED)


TRACKING = _Tracking({'R': number, 'W': number})
"""The task."""
