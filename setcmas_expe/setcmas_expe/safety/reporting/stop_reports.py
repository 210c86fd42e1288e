"""Reports of stopped robots: once why, and once when it is over."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from setcmas_simu.fleet.fleet import robots_in_words

OVER_AFTER_S = 0.5
"""How long a reason must be gone until it counts as over: a robot at the edge comes and goes."""


class StopReports:
    """Turns the reasons of each moment into messages that are not repeated."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Report through a function that shows a message to the user."""
        self._warn = warn
        self._told: dict[int, str] = {}
        self._gone_since: dict[int, float] = {}

    def update(self, reasons: Mapping[int, str], now: float) -> None:
        """Take the reason of each robot at a time (s); empty for those that are free."""
        started: dict[str, list[int]] = {}
        over: list[int] = []
        for robot, reason in reasons.items():
            if reason:
                self._gone_since.pop(robot, None)
                if self._told.get(robot) != reason:
                    self._told[robot] = reason
                    started.setdefault(reason, []).append(robot)
            elif (
                robot in self._told
                and now - self._gone_since.setdefault(robot, now) >= OVER_AFTER_S
            ):
                del self._told[robot], self._gone_since[robot]
                over.append(robot)
        for reason, robots in started.items():
            self._warn(f'{_robots(robots)} stopped: {reason}')
        if over:
            self._warn(f'{_robots(over)} free to move again')


def _robots(robots: list[int]) -> str:
    return robots_in_words(sorted(robots))
