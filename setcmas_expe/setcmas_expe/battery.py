"""Charge of a robot's battery, in whatever scale its node sends it."""

from __future__ import annotations

import math

LOW_PERCENT = 15.0
"""Charge from which people are told."""


class Battery:
    """Reads sensor_msgs/BatteryState.percentage.

    The message says 0 to 1; turtlebot3_node sends 0 to 100. Only what has once been above 1 is
    in percent, so that 0.04 is told as 4 %.
    """

    def __init__(self) -> None:
        """Know nothing yet."""
        self._in_percent = False

    def percent(self, percentage: float) -> float | None:
        """Return the charge in percent; None if it is not told."""
        if not math.isfinite(percentage):
            return None
        self._in_percent = self._in_percent or percentage > 1.0
        return float(percentage if self._in_percent else 100.0 * percentage)
