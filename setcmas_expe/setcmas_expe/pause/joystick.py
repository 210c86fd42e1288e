"""Joystick: its start button, and its absence."""

from __future__ import annotations

import math
from collections.abc import Sequence

SILENT_AFTER_S = 0.5
"""Age in s of the last message from which a joystick counts as gone; it sends 20 a second."""


class Joystick:
    """Watches the messages of a joystick.

    Attributes:
        missing_button: Whether the joystick has too few buttons for the one that is watched.
    """

    def __init__(self, button: int) -> None:
        """Watch a button, counted from 0."""
        self.missing_button = False
        self._button = button
        self._down: bool | None = None
        self._heard = -math.inf
        self._here = False

    def pressed(self, buttons: Sequence[int], now: float) -> bool:
        """Take a message that arrived at a time (s); returns whether the button went down.

        A button that is down in the first message was not seen going down.
        """
        self._heard, self._here = now, True
        self.missing_button = self._button >= len(buttons)
        down = not self.missing_button and bool(buttons[self._button])
        before, self._down = self._down, down
        return down and before is False

    def disappeared(self, now: float) -> bool:
        """Return, once, whether a joystick that was there has gone silent."""
        if not self._here or now - self._heard <= SILENT_AFTER_S:
            return False
        self._here, self._down = False, None
        return True
