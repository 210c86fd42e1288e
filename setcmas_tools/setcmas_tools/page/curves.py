"""What is measured of a run over time: disagreement, separation, speeds, errors of its task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.compare.run_distance import distances_between
from setcmas_tools.measures.consensus_metrics import disagreement, is_agreement
from setcmas_tools.measures.safety_metrics import distances_of_pairs
from setcmas_tools.measures.task import task_of
from setcmas_tools.plots.trajectories import ignore
from setcmas_tools.run.fleet_motion import SAME_TIME_S, Track
from setcmas_tools.run.run import Run

FLEET = 0
"""The number under which a curve has the values of the whole fleet."""


@dataclass(frozen=True)
class Curve:
    """What is measured over time.

    Attributes:
        name: Such as 'Disagreement'.
        unit: Such as 'm'.
        t: K times in s.
        values: By robot, or one of the whole `FLEET`, shape (K,); NaN where nothing is known.
    """

    name: str
    unit: str
    t: Floats
    values: Mapping[int, Floats]


def curves(run: Run) -> list[Curve]:
    """Return what is measured of a run from its first command on, as plots and metrics do."""
    grid = run.counted_grid if len(run.counted.t) else run.grid()
    found = [
        Curve('Speed', 'm/s', grid.t, {robot: _speeds(run, robot, grid.t) for robot in run.robots})
    ]
    if len(grid.robots) > 1 and len(grid.t):
        least = distances_of_pairs(grid)[0]
        found.insert(0, Curve('Least separation', 'm', grid.t, {FLEET: least}))
        if is_agreement(run):
            values = disagreement(grid.x, grid.y)
            found.insert(0, Curve('Disagreement', 'm', grid.t, {FLEET: values}))
    known = task_of(run, ignore)
    errors = known[0].errors(run, known[1]) if known and len(run.counted.t) else None
    if errors:
        found.append(Curve(errors.title, 'm', grid.t, errors.values))
    return found


def difference(run: Run, other: Run) -> Curve | None:
    """Return how far each robot of a run is from itself in another one at the same time, in m.

    None if no robot is in both.
    """
    t, distances = distances_between(run, other)
    return Curve('Difference', 'm', t, distances) if len(t) and distances else None


def _speeds(run: Run, robot: int, t: Floats) -> Floats:
    """Return a robot's speed at times, which a row tells for the time before it; NaN in gaps."""
    track = Track(run[robot])
    speeds = np.append(track.rows.v, np.nan)[np.searchsorted(track.rows.t, t - SAME_TIME_S)]
    return np.where(np.isnan(track.poses(t)[0]), np.nan, speeds)
