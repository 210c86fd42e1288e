"""States of robots in words: moving, standing, paused, why stopped, lost."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_tools.view.model.fleet_view import MOVING_M_S

OK, WARN, ERROR = 0, 1, 2
"""Levels, as of diagnostic_msgs/DiagnosticStatus."""

_PAUSED_TIMEOUT_S = 0.5
_DIAGNOSIS_TIMEOUT_S = 2.0


@dataclass(frozen=True)
class Diagnosis:
    """What an experiment says of a robot: level, state, and why it is held."""

    level: int
    state: str
    reason: str
    time: float


class RobotStates:
    """What was said about pauses, and by the diagnostics of an experiment.

    Attributes:
        wished: Whether the last wish was to pause.
        stopped: Whether the pause node of an experiment holds an emergency stop.
    """

    def __init__(self) -> None:
        """Start with robots that are free to go."""
        self.wished = self.stopped = False
        self._paused = False
        self._paused_time: float | None = None
        self._diagnoses: dict[int, Diagnosis] = {}

    def wish(self, paused: bool) -> None:
        """Note what somebody asked for; in a simulation it is what happens."""
        self.wished = paused

    def announce(self, paused: bool, now: float) -> None:
        """Note the state that the pause node of an experiment tells."""
        self._paused, self._paused_time = paused, now

    def diagnose(self, robot: int, diagnosis: Diagnosis) -> None:
        """Note what an experiment says of a robot."""
        self._diagnoses[robot] = diagnosis

    def paused(self, now: float) -> bool:
        """Return whether the fleet is paused."""
        if self._paused_time is None:
            return self.wished
        return self._paused or now - self._paused_time > _PAUSED_TIMEOUT_S

    def describe(self, robot: int, lost: bool, speed: float, now: float) -> tuple[int, str]:
        """Return the level and the state of a robot in words.

        Args:
            robot: Its number.
            lost: Whether nothing is heard of it.
            speed: In m/s.
            now: Time in s.
        """
        if lost:
            return ERROR, 'lost'
        said = self._diagnoses.get(robot)
        if said and now - said.time <= _DIAGNOSIS_TIMEOUT_S:
            parts = dict.fromkeys(filter(None, (said.state, said.reason)))  # each once
            return said.level, ': '.join(parts)
        if self.paused(now):
            return WARN, 'paused'
        return OK, 'moving' if abs(speed) >= MOVING_M_S else 'standing'
