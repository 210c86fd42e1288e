"""How long the control laws took."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from setcmas_tools.kinds.metric import Columns, Measured
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class CallTime(Measured):
    """Mean time per call of each robot's control law, which differs between equal runs."""

    in_file: ClassVar[bool] = False

    mean_call_time_s: dict[int, float]

    def columns(self) -> Columns:
        """Return the time of each robot."""
        milliseconds = {robot: time * 1e3 for robot, time in self.mean_call_time_s.items()}
        return {'call\n(ms)': ('.3f', milliseconds)}


def call_time(run: Run) -> CallTime | None:
    """Return how long the laws of a run took; None if nobody measured it."""
    if run.call_time is None:
        return None
    return CallTime(dict(enumerate(run.call_time.tolist(), start=1)))
