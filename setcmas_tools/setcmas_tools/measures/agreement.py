"""Agreement of robots on the position, which is measured in every run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import SLOW, Motion
from setcmas_simu.robots.models_by_name import motion_of
from setcmas_tools.measures.metric import Measured
from setcmas_tools.measures.task_errors import from_share, rms
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run, models_of

_LEAST_DECAY = 1.5
"""Factor by which values decay at least where a rate is fitted."""

_STILL = 1e-6  # m/s

CONSENSUS = 'consensus'
"""Name of the task of robots that should meet."""


def is_agreement(run: Run) -> bool:
    """Return whether a run may be about agreement: robots with another task need not meet."""
    return run.references is None or run.references.task == CONSENSUS


def fleet_consensus(run: Run) -> Measured | None:
    """Return the agreement of a run's fleet on the position; None for one robot.

    It has lines if the robots are meant to meet, or met without a task.
    """
    grid, models = run.counted_grid, models_of(run)
    free = [motion_of(models[robot]) is Motion.FREE for robot in grid.robots]
    found = consensus(grid, np.where(free, 0.0, SLOW))
    if not found:
        return None
    must_meet = is_agreement(run) and (run.references is not None or have_met(found))
    return Measured(found, _lines(found) if must_meet else [])


def have_met(agreement: Mapping[str, Any]) -> bool:
    """Return whether the disagreement has settled within 5 %."""
    return agreement['settling_time_5_percent_s'] is not None


def _lines(found: Mapping[str, Any]) -> list[str]:
    x, y = (round(found[f'final_centre_{axis}_m'], 2) + 0.0 for axis in 'xy')
    return [
        f'disagreement: {found["disagreement_at_start_m"]:.3f} m at the start, '
        f'{found["disagreement_at_end_m"]:.3f} m at the end; '
        f'below 5 % {_when(found["settling_time_5_percent_s"])}, '
        f'below 2 % {_when(found["settling_time_2_percent_s"])}',
        f'centre at the end: ({x:.2f}, {y:.2f}) m',
    ]


def _when(time: float | None) -> str:
    return 'not reached' if time is None else f'from {time:.1f} s on'


def disagreement(x: Floats, y: Floats) -> Floats:
    """Return the root mean square distance of N robots to their centre in m, from x and y (N, K).

    It is |delta| / sqrt(N), with the disagreement vector delta = p - (1 1^T / N) p of
    Olfati-Saber and Murray, IEEE Transactions on Automatic Control 49(9), 2004. It decays at the
    theoretical rate; the square root makes fleets of different sizes comparable. Their Lyapunov
    function is N / 2 times its square.
    """
    squares = (x - x.mean(axis=0)) ** 2 + (y - y.mean(axis=0)) ** 2
    result: Floats = np.sqrt(squares.mean(axis=0))
    return result


def settling_time(t: Floats, values: Floats, share: float) -> float | None:
    """Return the first time in t after which values stay within a share of the first; shapes (K,).

    None if the last value is above. Definition: Ogata, Modern Control Engineering, chapter 5
    (2 % and 5 %).
    """
    outside = np.flatnonzero(values > share * values[0])
    settled = int(outside[-1]) + 1 if len(outside) else 0
    return float(t[settled]) if settled < len(t) else None


def convergence_rate(t: Floats, values: Floats, resting: NDArray[np.bool_]) -> float | None:
    """Return the decay rate r in 1/s of values, as in exp(-r t); all arguments have shape (K,).

    The least-squares slope of their logarithm between 20 % and 2 % of the first value, where the
    slowest mode of linear consensus dominates: its rate is K lambda_2 (Olfati-Saber and Murray,
    IEEE Transactions on Automatic Control 49(9), 2004). The fit ends where all robots are in
    their dead band (`resting`). None for fewer than three values, or if they hardly decay.
    """
    first = int(np.argmax(values < 0.2 * values[0]))
    ends = np.flatnonzero((values < 0.02 * values[0]) | resting)
    end = next((int(k) for k in ends if k >= first), len(values))
    chosen = slice(first, end)
    if not first or len(t[chosen]) < 3 or values[chosen].min() <= 0:
        return None
    if values[first] < _LEAST_DECAY * values[end - 1]:
        return None
    return -float(np.polyfit(t[chosen], np.log(values[chosen]), 1)[0])


def _resting(t: Floats, x: Floats, y: Floats, dead_bands: Floats) -> NDArray[np.bool_]:
    """Return at which times no robot is faster than its dead band, shape (K,)."""
    if len(t) < 2:
        return np.zeros(len(t), bool)
    speeds = np.hypot(np.diff(x), np.diff(y)) / np.diff(t)
    return np.append((speeds <= dead_bands[:, None] + _STILL).all(axis=0), False)


def consensus(grid: FleetGrid, dead_bands: Floats) -> dict[str, float | None] | None:
    """Return the agreement of a fleet; None for one robot, or if not all are known at once.

    It is measured from the first to the last time with all poses known. Settling times are None if
    the disagreement is above its bound at the end; the rate is None if the disagreement hardly
    falls below 20 % before all robots rest. `dead_bands` (N,) are the speeds in m/s up to which
    each robot does not follow its law.
    """
    known = np.isfinite(grid.x).all(axis=0)
    if len(grid.robots) < 2 or not known.any():
        return None
    t, x, y = grid.t[known], grid.x[:, known], grid.y[:, known]
    values = disagreement(x, y)
    return {
        'start_time_s': float(t[0]),
        'end_time_s': float(t[-1]),
        'disagreement_at_start_m': float(values[0]),
        'disagreement_at_end_m': float(values[-1]),
        'disagreement_rms_second_half_m': rms(values[from_share(t, 0.5)]),
        'settling_time_2_percent_s': settling_time(t, values, 0.02),
        'settling_time_5_percent_s': settling_time(t, values, 0.05),
        'convergence_rate_1_s': convergence_rate(t, values, _resting(t, x, y, dead_bands)),
        'final_centre_x_m': float(x[:, -1].mean()),
        'final_centre_y_m': float(y[:, -1].mean()),
    }
