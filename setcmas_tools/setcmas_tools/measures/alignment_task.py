"""The task `alignment`: robots agree on a velocity, or on its direction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.measures.consensus_metrics import convergence_rate, disagreement
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.task import Errors, Task

if TYPE_CHECKING:
    from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class AlignmentMetrics(Measured):
    """Agreement on the velocities that the laws command.

    The disagreement is the root mean square distance to the mean velocity, the spread of
    directions the angle of the smallest sector with those of all moving robots.
    """

    disagreement_at_start_m_s: float
    disagreement_at_end_m_s: float
    convergence_rate_1_s: float | None
    final_mean_vx_m_s: float
    final_mean_vy_m_s: float
    spread_of_directions_at_end_rad: float

    def lines(self) -> list[str]:
        """Return the agreement at the start and at the end, and the rate."""
        rate = self.convergence_rate_1_s
        return [
            f'disagreement of velocities: {self.disagreement_at_start_m_s:.3f} m/s at the start, '
            f'{self.disagreement_at_end_m_s:.3f} m/s at the end',
            f'convergence rate: {"unknown" if rate is None else f"{rate:.3g} 1/s"}',
            f'mean velocity at the end: ({self.final_mean_vx_m_s:.3f}, '
            f'{self.final_mean_vy_m_s:.3f}) m/s; directions within '
            f'{self.spread_of_directions_at_end_rad:.3f} rad',
        ]


def velocities(run: Run) -> Floats | None:
    """Return the commands vx and vy in m/s at the times of `Run.counted_grid`, shape (2, N, K).

    None for one robot, or if the commands of a robot are unknown.
    """
    grid, commands = run.counted_grid, run.commands
    own = [commands.of(robot) for robot in grid.robots] if commands else []
    if len(own) < 2 or not all(len(one.t) for one in own):
        return None
    return np.array(
        [[np.interp(grid.t, one.t, getattr(one, name)) for one in own] for name in ('vx', 'vy')]
    )


def spread(vx: Floats, vy: Floats) -> float:
    """Return the angle in rad of the smallest sector with the directions of N velocities (N,)."""
    angles = np.sort(np.arctan2(vy, vx)[np.hypot(vx, vy) > 0.0])
    gaps = np.diff(angles, append=angles[:1] + 2 * np.pi)
    return float(2 * np.pi - gaps.max()) if len(gaps) else 0.0


def alignment(t: Floats, vx: Floats, vy: Floats) -> AlignmentMetrics:
    """Return the agreement of velocities in m/s, shape (N, K), at times in s, shape (K,)."""
    values = disagreement(vx, vy)
    return AlignmentMetrics(
        disagreement_at_start_m_s=float(values[0]),
        disagreement_at_end_m_s=float(values[-1]),
        convergence_rate_1_s=convergence_rate(t, values, np.zeros(len(t), bool)),
        final_mean_vx_m_s=float(vx[:, -1].mean()),
        final_mean_vy_m_s=float(vy[:, -1].mean()),
        spread_of_directions_at_end_rad=spread(vx[:, -1], vy[:, -1]),
    )


class _Alignment(Task):
    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        del references
        found = velocities(run)
        return {'alignment': None if found is None else alignment(run.counted_grid.t, *found)}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors | None:
        del references
        found = velocities(run)
        if found is None:
            return None
        gaps = np.hypot(*(found - found.mean(axis=1, keepdims=True)))
        values = dict(zip(run.counted_grid.robots, gaps, strict=True))
        return Errors('Alignment error', 'distance to the mean velocity (m/s)', values)


ALIGNMENT = _Alignment()
"""The task."""
