"""Time of a scenario: how long it lasts, and how simulated time goes by."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.options.group import option
from setcmas_simu.options.kinds import DURATION
from setcmas_simu.simulator.simulator_options import ClockOptions


@dataclass(frozen=True, kw_only=True)
class TimeOptions(ClockOptions):
    """How long a run takes, and how simulated time goes by."""

    duration: float = option(
        DURATION,
        'length of the run, from the first command',
        default=40.0,
    )
