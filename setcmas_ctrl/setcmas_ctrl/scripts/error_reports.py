"""Reports of failing scripts: once for each distinct error, a count of the rest, and the end."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable

import msgspec

from setcmas_ctrl.scripts.failures import ControlError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.reports import Function, ScriptFailure

STANDS = 'is commanded zero; this stops no other robot'
"""What happens to a robot whose control law fails."""

MOST_FAILURES = 500
"""So many are kept with their times; a law may fail and work again at each other call."""


class ErrorReports:
    """Turns the errors of a fleet's scripts into messages that are not repeated.

    Attributes:
        failures: When which script failed for whom, the first ones, sorted by time.
    """

    def __init__(
        self,
        warn: Callable[[str], None],
        consequence: str = STANDS,
        on_new: Callable[[int, str], None] = lambda *_: None,
        function: Function = Function.CONTROL,
    ) -> None:
        """Report through a function that shows a message to the user.

        Args:
            warn: Shows a message to the user.
            consequence: What happens to a robot whose script fails, after its name.
            on_new: Takes robot and text of an error that is new for the robot.
            function: What of a script is called.
        """
        self.failures: list[ScriptFailure] = []
        self._function = function
        self._open: dict[int, tuple[int, object]] = {}  # by robot, which failure goes on, its key
        self._warn = warn
        self._on_new = on_new
        self._consequence = consequence
        self._counts: Counter[tuple[int, object]] = Counter()
        self._failing: Counter[int] = Counter()
        self._first: dict[str, int] = {}  # the robot for which a text was shown

    def failed(self, robot: int, t: float, error: ControlError) -> None:
        """Note that a robot's script failed at time t (s)."""
        self._keep(robot, t, error)
        self._failing[robot] += 1
        self._counts[robot, error.key] += 1
        if self._counts[robot, error.key] == 1:
            self._on_new(robot, str(error))
            name = robot_name(robot)
            first = self._first.setdefault(str(error), robot)
            if first == robot:
                consequence = error.consequence or self._consequence
                self._warn(f'{name} at t = {t:.1f} s: {error}\n    {name} {consequence}')
            else:
                self._warn(f'{name} at t = {t:.1f} s: the same error as {robot_name(first)}')

    def succeeded(self, robot: int, t: float) -> None:
        """Note that a robot's script did its work at time t (s)."""
        if robot in self._failing:
            self._close(robot, t)
            count = self._failing.pop(robot)
            calls = 'call' if count == 1 else 'calls'
            self._warn(f'{robot_name(robot)} at t = {t:.1f} s: works again after {count} {calls}')

    def _keep(self, robot: int, t: float, error: ControlError) -> None:
        if robot in self._open and self._open[robot][1] == error.key:
            return  # the text may hold other numbers
        self._close(robot, t)
        if len(self.failures) < MOST_FAILURES:
            file, line = error.place or (None, None)
            script = file.name if file else ''
            self._open[robot] = len(self.failures), error.key
            self.failures.append(
                ScriptFailure(round(t, 3), robot, self._function, script, line, str(error))
            )

    def _close(self, robot: int, t: float) -> None:
        if robot in self._open:
            number, _ = self._open.pop(robot)
            ended = msgspec.structs.replace(self.failures[number], until=round(t, 3))
            self.failures[number] = ended

    @property
    def failed_robots(self) -> list[int]:
        """The robots whose script has failed at some time, sorted."""
        return sorted({robot for robot, _ in self._counts})

    def summary(self) -> list[str]:
        """Return a line for each error that occurred more than once to a robot."""
        robots_of: defaultdict[object, list[int]] = defaultdict(list)
        for (robot, key), count in self._counts.items():
            if count > 1:
                robots_of[key].append(robot)
        return [self._summed_up(key, robots) for key, robots in robots_of.items()]

    def _summed_up(self, key: object, robots: list[int]) -> str:
        count = sum(self._counts[robot, key] for robot in robots)
        if len(robots) == 1:
            return f'{robot_name(robots[0])}: {_name(key)} occurred {count} times'
        return f'{robots_in_words(sorted(robots))}: {_name(key)} occurred {count} times in all'


def _name(key: object) -> str:
    if isinstance(key, tuple) and key[0] != 'result':
        kind, file, line = key
        return f'{kind} in {file.name}, line {line}' if line else str(kind)
    return 'a result that is of no use'
