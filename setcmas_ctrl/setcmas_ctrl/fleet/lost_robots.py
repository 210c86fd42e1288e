"""Robots of a process without odometry for too long."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from setcmas_ctrl.fleet.odometry import FleetOdometry


class LostRobots:
    """Says whose odometry is too old; tells it, and when it is back."""

    def __init__(
        self, robots: Sequence[int], odometry: FleetOdometry, warn: Callable[[str], None]
    ) -> None:
        """Begin with none lost; `warn` shows a message to the user."""
        self._robots = robots
        self._odometry = odometry
        self._warn = warn
        self._lost: set[int] = set()

    def __contains__(self, robot: int) -> bool:
        """Return whether a robot is lost."""
        return robot in self._lost

    def look(self, timeout_s: float) -> None:
        """Look whose odometry is older than a time in s."""
        for robot in self._robots:
            age = self._odometry.age(robot)
            if age > timeout_s and robot not in self._lost:
                self._lost.add(robot)
                self._warn(f'robot {robot}: no odometry for {age:.1f} s; it is commanded zero')
            elif age <= timeout_s and robot in self._lost:
                self._lost.remove(robot)
                self._warn(f'robot {robot}: odometry is back')
