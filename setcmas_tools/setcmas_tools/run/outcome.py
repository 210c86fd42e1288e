"""How a run ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from setcmas_simu.fleet.fleet import format_robots


class State(Enum):
    """What became of a run."""

    NOT_FINISHED = 'not finished'
    """It is running, or was killed."""
    COMPLETE = 'complete'
    FAILED = 'failed'
    """It is complete, but a script failed for some robots."""
    NOT_STARTED = 'not started'
    """The robots did not start."""
    STOPPED = 'stopped'
    """The user has stopped it."""
    DIED = 'died'
    """A process of it has died."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        state: In a word.
        failed_laws: The robots for which each control script failed at some time, by script.
        failed_conditions: The same of triggering conditions.
        detail: What there is to say beyond, such as which process died of what.
    """

    state: State
    failed_laws: dict[str, list[int]] = field(default_factory=dict)
    failed_conditions: dict[str, list[int]] = field(default_factory=dict)
    detail: str = ''

    def __str__(self) -> str:
        """Return the outcome for people, such as 'complete, but law.py failed for robot 2'."""
        failures = [
            *(f'{name} failed for {_listed(r)}' for name, r in self.failed_laws.items()),
            *(
                f'the condition {name} failed for {_listed(robots)}'
                for name, robots in self.failed_conditions.items()
            ),
        ]
        if self.state is State.FAILED:
            return f'complete, but {" and ".join(failures) or "a script failed for some robots"}'
        text = {State.STOPPED: 'stopped by the user'}.get(self.state, self.state.value)
        return f'{text}: {self.detail}' if self.detail else text

    @classmethod
    def of_failures(
        cls,
        failed_laws: Mapping[str, list[int]],
        failed_conditions: Mapping[str, list[int]] | None = None,
    ) -> Outcome:
        """Return the outcome of a run that went on to its end.

        Args:
            failed_laws: Robots by control script; robots may be none.
            failed_conditions: Robots by triggering condition.
        """
        laws = {name: robots for name, robots in failed_laws.items() if robots}
        conditions = {name: rs for name, rs in (failed_conditions or {}).items() if rs}
        return cls(State.FAILED if laws or conditions else State.COMPLETE, laws, conditions)


def _listed(robots: list[int]) -> str:
    return f'robot{"s" * (len(robots) > 1)} {format_robots(sorted(robots))}'
