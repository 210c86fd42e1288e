"""Loop that calls a step at a fixed rate."""

from __future__ import annotations

import math
from collections.abc import Callable

from setcmas_simu.ros.process import RosProcess
from setcmas_simu.ros.step_clock import SteadyClock, StepClock

_POLL_EVERY_S = 0.01
_SAME_TIME = 1e-6


class StepLoop:
    """Calls a step at a fixed rate; in between, its process serves rare callbacks.

    The step itself polls frequent messages: a callback for each would wake an executor that
    rebuilds its wait set every time.

    Attributes:
        period: Time in s between steps; a change takes effect at the next step.
        poll: Also called between steps, for what cannot wait for the next one.
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
            process: Served between steps; ends the loop when it stops.
            period: Time in s between steps.
            step: Called with the clock's time in s.
            clock: The clock to follow; real time by default.
        """
        self.period = period
        self.poll: Callable[[], None] | None = None
        self._process = process
        self._step = step
        self._clock = clock or SteadyClock()

    @property
    def wall_period(self) -> float:
        """Real time in s between steps."""
        return self.period / self._clock.rtf

    def run(self) -> None:
        """Step at once and then every period, until the process must stop.

        A late step does not shift the next ones; steps whose time has passed are skipped.
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
            # Count back from the step, so that the last poll comes just before it.
            nb_polls = math.ceil((due - self._clock.now()) / _POLL_EVERY_S - _SAME_TIME) - 1
            for left in range(nb_polls, 0, -1):
                self._clock.wait_until(due - left * _POLL_EVERY_S, self._process)
                if self._process.stopping:
                    return
                self.poll()
        self._clock.wait_until(due, self._process)
