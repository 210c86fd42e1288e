"""Reports of scripts whose calls, for all robots together, exceed the control period."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path

from setcmas_simu.fleet.topics import robot_name

_REPORT_EVERY_S = 5.0


class SlowCalls:
    """Adds up, script by script, how long the calls of a control period take.

    Attributes:
        period: Control period in s.
    """

    def __init__(self, period: float, warn: Callable[[str], None]) -> None:
        """Report through a function that shows a message to the user.

        Args:
            period: Control period in s.
            warn: Shows a message to the user.
        """
        self.period = period
        self._warn = warn
        self._spent: defaultdict[Path, defaultdict[int, float]] = defaultdict(
            lambda: defaultdict(float)
        )
        self._times: Counter[Path] = Counter()
        self._next_report: dict[Path, float] = {}

    def add(self, path: Path, robot: int, duration: float) -> None:
        """Note that a call of a script for a robot has taken a duration (s)."""
        self._spent[path][robot] += duration

    def end_period(self, now: float) -> None:
        """End a control period at a time (s), and tell of scripts that were slow in it."""
        for path, spent in self._spent.items():
            if sum(spent.values()) > self.period:
                self._times[path] += 1
                if now >= self._next_report.get(path, now):
                    self._next_report[path] = now + _REPORT_EVERY_S
                    self._tell(path, spent)
        self._spent.clear()

    def _tell(self, path: Path, spent: Mapping[int, float]) -> None:
        longest, robot = max((duration, robot) for robot, duration in spent.items())
        count = f'{self._times[path]} time' + ('s' if self._times[path] > 1 else '')
        robots = f'{len(spent)} robot{"s" * (len(spent) > 1)}'
        self._warn(
            f'{path.name} took {sum(spent.values()):.2f} s for {robots} '
            f'({longest:.2f} s for {robot_name(robot)}), longer than the control period of '
            f'{self.period:.2f} s ({count} so far)'
        )
