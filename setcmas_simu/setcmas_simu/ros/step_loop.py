"""Loop of steps at a fixed rate."""

from __future__ import annotations

import math
from collections.abc import Callable

from setcmas_simu.ros.process import RosProcess
from setcmas_simu.ros.step_clock import SteadyClock, StepClock

_POLL_EVERY_S = 0.01
_SAME_TIME = 1e-6


class StepLoop:
    """Calls a step at a fixed rate; in between its process serves what is rare.

    What is frequent is polled by the step: a callback for each message would wake an executor
    that rebuilds its wait set every time.

    Attributes:
        period: Time in s from step to step; a change counts from the next step on.
        poll: Called between steps too, for what cannot wait until the next one.
    """

    def __init__(
        self,
        process: RosProcess,
        period: float,
        step: Callable[[float], None],
        clock: StepClock | None = None,
    ) -> None:
        """Prepare.

        Args:
            process: Is served between steps, and says when to stop.
            period: Time in s from step to step.
            step: Is given the time of the clock in s.
            clock: The time to follow; the wall's by default.
        """
        self.period = period
        self.poll: Callable[[], None] | None = None
        self._process = process
        self._step = step
        self._clock = clock or SteadyClock()

    @property
    def wall_period(self) -> float:
        """Time in s of the wall's clock from step to step."""
        return self.period / self._clock.rtf

    def run(self) -> None:
        """Step at once and then at every period, until the process is to stop.

        A step that is late moves none of the others; those that would lie in the past are left
        out.
        """
        due = self._clock.now()
        while not self._process.stopping:
            now = self._clock.now()
            self._step(now)
            due += self.period
            behind = self._clock.now() - due
            if behind > 0.0:
                due += self.period * math.floor(behind / self.period)
            self._wait(due)

    def _wait(self, due: float) -> None:
        if self.poll:
            # Counted back from the step, so that the last one is right before it.
            nb_polls = math.ceil((due - self._clock.now()) / _POLL_EVERY_S - _SAME_TIME) - 1
            for left in range(nb_polls, 0, -1):
                self._clock.wait_until(due - left * _POLL_EVERY_S, self._process)
                if self._process.stopping:
                    return
                self.poll()
        self._clock.wait_until(due, self._process)
