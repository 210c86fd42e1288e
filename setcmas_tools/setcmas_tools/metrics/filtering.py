"""What the safety filter did: for how long it overruled and blocked each robot."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from setcmas_ctrl.filter.verdict import Verdict
from setcmas_tools.kinds.metric import Columns, Measured
from setcmas_tools.records.commands import Commands
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class Filtering(Measured):
    """What the filter did, by robot."""

    overruled_s: dict[int, float]
    blocked_s: dict[int, float]
    steps_without_solution: int

    def columns(self) -> Columns:
        """Return the times of each robot."""
        return {
            'overruled\n(s)': ('.1f', self.overruled_s),
            'blocked\n(s)': ('.1f', self.blocked_s),
        }

    def lines(self, task: str | None) -> list[str]:
        """Return how often there was no solution, if ever."""
        del task
        count = self.steps_without_solution
        steps = f'{count} step{"s" if count != 1 else ""}'
        return [f'safety filter: no solution in {steps}, robots stood'] if count else []


def fleet_filtering(run: Run) -> Filtering | None:
    """Return what the filter of a run did; None if it had none."""
    commands = run.commands
    if commands is None or commands.allowed is None:
        return None
    robots = {int(robot): commands.of(int(robot)) for robot in np.unique(commands.robot)}
    unsolved = commands.t[commands.allowed.verdict == Verdict.NO_SOLUTION]
    return Filtering(
        {robot: _lasting(own, Verdict.CHANGED) for robot, own in robots.items()},
        {robot: _lasting(own, Verdict.BLOCKED) for robot, own in robots.items()},
        len(np.unique(unsolved)),
    )


def _lasting(commands: Commands, least: Verdict) -> float:
    """Return for how long, in s, a robot's verdict was this or a graver one."""
    assert commands.allowed
    held = (commands.t >= 0.0) & (commands.allowed.verdict >= least)
    period = float(np.median(np.diff(commands.t))) if len(commands.t) > 1 else 0.0
    return round(float(held.sum()) * period, 3)
