"""Verdict of the safety filter on a wanted velocity."""

from __future__ import annotations

import enum


class Verdict(enum.IntEnum):
    """What became of the velocity that a law wants."""

    KEPT = 0
    CHANGED = 1
    BLOCKED = 2
    NO_SOLUTION = 3
