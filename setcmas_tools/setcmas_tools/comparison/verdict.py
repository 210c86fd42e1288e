"""Verdict on a simulation and an experiment of the same fleet: where they part, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_tools.comparison.delay import RATE_HZ, delay_of
from setcmas_tools.comparison.shift import Shifted, best_shift
from setcmas_tools.identification.drive import Drive
from setcmas_tools.identification.steps import steps_of
from setcmas_tools.measures.safety_metrics import held
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.run.run import Run

PART_M = 0.1
"""Distance in m from which robots have parted."""

PART_S = 2.0
"""Time in s for which they stay further apart than that, or to the end."""

_TOP = 95.0  # percent: a top speed that a few wrong poses do not make
_TURNS = 0.1  # rad/s: slower turns are noise


@dataclass(frozen=True)
class Reached:
    """A speed that was asked of a robot and the one that it had: both in m/s, or in rad/s."""

    asked: float
    had: float


@dataclass(frozen=True)
class Verdict:
    """What a robot did in an experiment, beside the simulation. None is what is not known.

    Attributes:
        parted: When it was `PART_M` from its simulation and stayed so, in s from the start.
        rms: Its distance after the best shift of the fleet in m, root mean square.
        delay: How much later than in the simulation its speeds change, in s.
        speed: Top forward speed, in m/s.
        turn: Top turn rate, in rad/s.
        stopped: For how long safety let it not move, in s.
        lost: Messages of it that were lost on links.
    """

    parted: float | None
    rms: float
    delay: float | None
    speed: Reached | None
    turn: Reached | None
    stopped: float
    lost: int | None


def is_experiment(run: Run) -> bool:
    """Return whether a run was an experiment, real or emulated: safety watched it."""
    return run.tables.safety is not None


def verdicts(simulation: Run, experiment: Run, drives: Mapping[int, Drive]) -> dict[int, Verdict]:
    """Return the verdict on each robot that is in both, by its number.

    Args:
        simulation: The simulation.
        experiment: The experiment.
        drives: What the robots of the experiment were commanded, of those of which that is known.

    Raises:
        SetcmasError: No robot is in both runs long enough.
    """
    shifted = best_shift(experiment, simulation)
    return {
        robot: _verdict(robot, simulation, experiment, shifted, drives.get(robot))
        for robot in shifted.rms
    }


def _verdict(
    robot: int, simulation: Run, experiment: Run, shifted: Shifted, drive: Drive | None
) -> Verdict:
    end = float(experiment.parameters.get('duration', np.inf))
    safety, record = experiment.tables.safety, experiment.record
    counts = record.robots.get(robot) if record else None
    reached = _reached(drive) if drive else (None, None)
    return Verdict(
        parted(shifted.t, shifted.distances[robot]),
        shifted.rms[robot],
        delay_of(_speeds(simulation.counted_grid, robot), _speeds(experiment.counted_grid, robot)),
        *reached,
        held(safety, robot, end)[1] if safety else 0.0,
        counts.lost if counts else None,
    )


def parted(t: Floats, distances: Floats) -> float | None:
    """Return when distances (m) exceed `PART_M` for `PART_S` or to the end; None if never."""
    known = np.isfinite(distances)
    t, apart = t[known], distances[known] > PART_M
    begins = np.flatnonzero(apart & ~np.concatenate([[False], apart[:-1]]))
    ends = np.flatnonzero(apart & ~np.concatenate([apart[1:], [False]]))
    lasting = (t[ends] - t[begins] >= PART_S) | (ends == len(apart) - 1)
    return float(t[begins[lasting][0]]) if lasting.any() else None


def _speeds(grid: FleetGrid, robot: int) -> Floats:
    """Return rows of speed (m/s) and turn rate (rad/s) of a robot, 10 a second, from t = 0 on."""
    row = grid.robots.index(robot)
    unseen = np.full((2, round(grid.t[0] * RATE_HZ)), np.nan)
    V = np.hypot(np.diff(grid.x[row]), np.diff(grid.y[row])) * RATE_HZ
    return np.hstack([unseen, [V, np.diff(grid.theta[row]) * RATE_HZ]])


def _reached(drive: Drive) -> tuple[Reached | None, Reached | None]:
    """Return the top speed and the top turn rate of a robot beside those that were commanded."""
    steps = steps_of(drive.seen)
    t, *asked = drive.commands
    if len(steps.begin) < 2 or not len(t):
        return None, None
    since = np.searchsorted(t, steps.begin, side='right') - 1
    tops = []
    for commanded, had, least in zip(asked, steps.speeds, (0.0, _TURNS), strict=True):
        held_then = np.where(since >= 0, np.abs(commanded[since]), 0.0)
        top = Reached(_top(held_then), _top(np.abs(had)))
        tops.append(top if top.asked > least else None)
    return tops[0], tops[1]


def _top(values: Floats) -> float:
    return float(np.percentile(values, _TOP))
