"""Verdict: what the safety filter did with the velocity of a law."""

from __future__ import annotations

import enum


class Verdict(enum.IntEnum):
    """What the safety filter did with a wanted velocity, as cmd_cart_vel_allowed has it in z."""

    KEPT = 0
    """The robot may have it: it is driven as without a filter, but within its limits."""

    CHANGED = 1
    """It may have another one: that of its control point, ahead of the axle of a unicycle."""

    NO_SOLUTION = 2
    """No velocity is safe: it stops."""
