"""Verdict on an experiment and its simulation: where they part, and why."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.table import Table
from setcmas_tools.compare.robot_drive import Drive, drives, steps_of
from setcmas_tools.compare.run_distance import (
    RATE_HZ,
    Shifted,
    best_shift,
    delay_of,
    is_experiment,
)
from setcmas_tools.measures.safety_metrics import held
from setcmas_tools.run.fleet_motion import FleetGrid
from setcmas_tools.run.run import Run

PART_M = 0.1
"""Distance in m from which robots have parted."""

PART_S = 2.0
"""Time in s for which they stay further apart than that, or to the end."""

_TOP = 95.0  # percent: a top speed that a few wrong poses do not make
_TURNS = 0.1  # rad/s: slower turns are noise


@dataclass(frozen=True)
class Reached:
    """Commanded and reached speed of a robot, both in m/s or in rad/s."""

    asked: float
    had: float


@dataclass(frozen=True)
class Verdict:
    """Motion of a robot in an experiment compared with the simulation; None if unknown.

    Attributes:
        parted: Time from which it was `PART_M` off its simulation and stayed so, in s.
        rms: Its distance after the best shift of the fleet in m, root mean square.
        delay: Delay of its speeds to the simulation in s.
        speed: Top forward speed, in m/s.
        turn: Top turn rate, in rad/s.
        stopped: Time that safety stopped it, in s.
        lost: Number of its messages lost on links.
    """

    parted: float | None
    rms: float
    delay: float | None
    speed: Reached | None
    turn: Reached | None
    stopped: float
    lost: int | None


def verdicts(simulation: Run, experiment: Run, drives: Mapping[int, Drive]) -> dict[int, Verdict]:
    """Return the verdict on each robot that is in both, by its number.

    Args:
        simulation: The simulation.
        experiment: The experiment.
        drives: Commands and motion of the robots of the experiment, where known.

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
    """Return commanded and reached top speed and top turn rate of a robot."""
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


_UNKNOWN = '-'
_HEADS = (
    'experiment', 'parts at (s)', 'RMS (m)', 'later by (s)', 'top speed (m/s)',
    'top turn (rad/s)', 'stopped (s)', 'messages lost',
)  # fmt: skip


def _cells(one: Verdict) -> list[str]:
    return [
        'never' if one.parted is None else f'{one.parted:.1f}',
        f'{one.rms:.3f}',
        _UNKNOWN if one.delay is None else f'{one.delay:.1f}',
        _share(one.speed),
        _share(one.turn),
        f'{one.stopped:.1f}',
        _UNKNOWN if one.lost is None else str(one.lost),
    ]


def _share(one: Reached | None) -> str:
    return f'{one.had:.2f} of {one.asked:.2f}' if one else _UNKNOWN


def _sentence(name: str, one: Verdict) -> str:
    """Return the verdict on a robot as text."""
    if one.parted is None:
        first = f'{name} stays with the simulation, {one.rms:.2g} m apart (RMS)'
    else:
        first = f'{name} is more than {PART_M:g} m off the simulation from {one.parted:.1f} s on'
    return '; '.join([first, *_reasons(one)])


def _reasons(one: Verdict) -> Iterator[str]:
    if one.delay:
        when = 'later' if one.delay > 0 else 'earlier'
        yield f'it moves {abs(one.delay):.1f} s {when} in the experiment'
    if one.speed and one.speed.had < 0.95 * one.speed.asked:
        yield f'its top speed is {one.speed.had / one.speed.asked:.0%} of that commanded'
    if one.turn and one.turn.had < 0.9 * one.turn.asked:
        yield f'its top turn rate is {one.turn.had / one.turn.asked:.0%} of that commanded'
    if one.stopped >= 1.0:
        yield f'safety stopped it for {one.stopped:.1f} s'
    if one.lost:
        yield f'{one.lost} of its messages were lost'


def _missing(found: Collection[Verdict]) -> Iterator[str]:
    """Yield the reasons for - in the table, a line each."""
    if any(one.speed is None for one in found):
        yield '- in top speeds: the commands (cmd_vel) of the experiment were not recorded'
    if any(one.delay is None for one in found):
        yield '- in later by: speeds are not alike enough, or do not change'
    if any(one.lost is None for one in found):
        yield '- in messages lost: all robots knew all poses; there were no links'


@dataclass(frozen=True)
class ExperimentVerdict:
    """Comparison of an experiment with its simulation.

    Attributes:
        title: Names of both.
        found: The verdict on each robot, by its number.
        hint: Advice to improve the simulation; may be empty.
    """

    title: str
    found: Mapping[int, Verdict]
    hint: str = ''

    def table(self) -> Table:
        """Return a table with a row for each robot; - stands for an unknown value."""
        rows = [[robot_name(robot), *_cells(one)] for robot, one in self.found.items()]
        return Table(rows, _HEADS, 'lr')

    @property
    def lines(self) -> list[str]:
        """The table in sentences, and the reasons for gaps."""
        sentences = [_sentence(robot_name(robot), one) for robot, one in self.found.items()]
        return [*sentences, *_missing(self.found.values()), *filter(None, [self.hint])]


def experiment_verdict(
    paths: Sequence[Path], runs: Sequence[Run], warn: Callable[[str], None]
) -> ExperimentVerdict | None:
    """Return the verdict on two runs; None unless one is an experiment and one a simulation.

    Args:
        paths: Paths of the two runs: commands are read from their bags.
        runs: The two runs.
        warn: Prints losses.
    """
    both = zip(paths, runs, strict=True)
    (simulated, simulation), (path, experiment) = sorted(
        both, key=lambda one: is_experiment(one[1])
    )
    if is_experiment(simulation) or not is_experiment(experiment):
        return None
    try:
        commanded = drives(path, warn)
    except SetcmasError:
        commanded = {}
    title = f'experiment {path} against simulation {simulated}'
    found = verdicts(simulation, experiment, commanded)
    hint = ''
    if commanded and any(one.parted is not None for one in found.values()):
        hint = (
            f'setcmas identify {path} finds a model of these robots, for simulations nearer to it'
        )
    return ExperimentVerdict(title, found, hint)
