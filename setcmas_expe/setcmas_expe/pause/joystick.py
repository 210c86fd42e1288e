"""Joystick: its buttons, and its absence."""

from __future__ import annotations

import math
from collections.abc import Sequence

SILENT_AFTER_S = 0.5
"""Age in s of the last message from which a joystick counts as gone; it sends 20 a second."""


class Joystick:
    """Watches the messages of a joystick.

    Attributes:
        held: Buttons that are down and were seen going down, counted from 0.
    """

    def __init__(self) -> None:
        """Begin without a joystick."""
        self.held: frozenset[int] = frozenset()
        self._down: frozenset[int] | None = None
        self._heard = -math.inf

    def pressed(self, buttons: Sequence[int], now: float) -> frozenset[int]:
        """Take a message that arrived at a time (s); returns the buttons that went down.

        Buttons that are down in the first message were not seen going down.
        """
        self._heard = now
        down = frozenset(button for button, state in enumerate(buttons) if state)
        new = down - (down if self._down is None else self._down)
        self._down, self.held = down, (self.held & down) | new
        return new

    def disappeared(self, now: float) -> bool:
        """Return, once, whether a joystick that was there has gone silent."""
        if self._down is None or now - self._heard <= SILENT_AFTER_S:
            return False
        self._down, self.held = None, frozenset()
        return True
