"""What the safety of an experiment had to do: stops, overruled commands, arena, separation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.world.arena import Arena
from setcmas_tools.kinds.metric import Measured
from setcmas_tools.records.fleet_grid import FleetGrid
from setcmas_tools.records.safety import MOVING, SafetyRecord
from setcmas_tools.run.arena import arena_of
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class Safety(Measured):
    """What happened from the start to the end of an experiment.

    Times of robots are added up; None is what cannot be told without the lab's arena or distance.
    """

    stops: int
    stopped_s: float
    overruled_s: float
    outside_arena_s: float | None
    too_near_s: float | None

    def lines(self, task: str | None) -> list[str]:
        """Return a line."""
        del task
        stops = f'{self.stops} stop{"s" if self.stops != 1 else ""}'
        times = {
            'stopped': self.stopped_s,
            'overruled': self.overruled_s,
            'outside the arena': self.outside_arena_s,
            'too near': self.too_near_s,
        }
        told = [f'{name} {time:.1f} s' for name, time in times.items() if time is not None]
        return [f'safety: {", ".join([stops, *told])}']


def fleet_safety(run: Run) -> Safety | None:
    """Return what the safety of a run had to do; None if it was no experiment."""
    record = run.tables.safety
    if record is None:
        return None
    grid, end = run.counted_grid, float(run.parameters.get('duration', np.inf))
    robots = [held(record, robot, end) for robot in np.unique(record.robot).tolist()]
    stops, stopped, overruled = (sum(column) for column in zip(*robots, strict=True))
    arena, least = arena_of(run), run.parameters.get('min_separation')
    return Safety(
        int(stops),
        round(stopped, 3),
        round(overruled, 3),
        _time_outside(grid, arena) if arena else None,
        _time_too_near(grid, float(least)) if least else None,
    )


def held(record: SafetyRecord, robot: int, end: float) -> tuple[int, float, float]:
    """Return how often a robot was stopped, and for how long (s) it was stopped and overruled.

    Args:
        record: What safety let robots do; its times from 0 on count.
        robot: Its number.
        end: Until when, in s.
    """
    mine = (record.robot == robot) & (record.t >= 0) & (record.t <= end)
    t, moving = record.t[mine], np.array([state == MOVING for state in record.state])[mine]
    lasts = np.diff(t, append=t[-1:])
    stops = int(np.count_nonzero(moving[:-1] & ~moving[1:]))
    return stops, float(lasts[~moving].sum()), float(lasts[record.overruled[mine]].sum())


def _time_outside(grid: FleetGrid, arena: Arena) -> float:
    x, y = grid.x, grid.y
    outside = (x < arena.xmin) | (x > arena.xmax) | (y < arena.ymin) | (y > arena.ymax)
    return _time(grid.t, outside.sum(axis=0))


def _time_too_near(grid: FleetGrid, least: float) -> float:
    """Return for how long robots were nearer than a distance (m), added up over pairs."""
    near = np.zeros(len(grid.t))
    for i in range(len(grid.robots) - 1):
        distances = np.hypot(grid.x[i + 1 :] - grid.x[i], grid.y[i + 1 :] - grid.y[i])
        near += (distances < least).sum(axis=0)
    return _time(grid.t, near)


def _time(t: Floats, counts: Floats) -> float:
    return round(float((counts[:-1] * np.diff(t)).sum()), 3)
