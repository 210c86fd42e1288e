"""Why the robots of an experiment are paused."""

from __future__ import annotations

import enum
from dataclasses import dataclass


class PauseCause(enum.Enum):
    """Why robots are paused; the values are texts for people."""

    OPERATOR = 'paused'
    SILENT = 'no message from the pause node'
    NOT_STARTED = 'the pause node sent a start without a pause before it'
    SEVERAL = 'several pause nodes publish /paused; is another experiment in this ROS domain?'
    EMERGENCY = 'a stop is held'
    LATCHED = 'stopped until a person starts'


@dataclass(frozen=True)
class PauseReason:
    """Why robots are paused.

    Attributes:
        cause: The kind of reason.
        text: The reason for people.
    """

    cause: PauseCause
    text: str

    @property
    def is_of_operator(self) -> bool:
        """Whether a start by the operator is all that is missing."""
        return self.cause is PauseCause.OPERATOR
