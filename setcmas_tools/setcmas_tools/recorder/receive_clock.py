"""Clock of receive times that never go back."""

from __future__ import annotations

import time
from collections.abc import Callable


class ReceiveClock:
    """Turns times of arrival on the system's clock into times for a bag.

    They start on the system's clock, but do not follow when somebody sets it during a recording:
    a jump of an hour would otherwise freeze or stretch the recorded run.
    """

    def __init__(
        self,
        system_ns: Callable[[], int] = time.time_ns,
        steady_ns: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """Start the clock.

        Args:
            system_ns: The system's clock, in ns.
            steady_ns: A clock that nobody sets, in ns.
        """
        self._system_ns = system_ns
        self._steady_ns = steady_ns
        self._offset = system_ns() - steady_ns()
        self._jump = 0
        self._last = 0

    def update(self) -> None:
        """Notice a jump of the system's clock; call it before each batch of messages."""
        self._jump = self._system_ns() - self._steady_ns() - self._offset

    def stamp(self, received_ns: int) -> int:
        """Return the time in ns of a message, not before that of the one before.

        Args:
            received_ns: When it arrived, on the system's clock; 0 if that is not known.
        """
        stamp = (received_ns or self._system_ns()) - self._jump
        self._last = max(self._last, stamp)
        return self._last
