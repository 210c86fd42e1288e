"""Joystick of the operator: one button starts robots, all others are a stop."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

from rclpy.node import Node
from sensor_msgs.msg import Joy

from setcmas_expe.lab.lab import Lab
from setcmas_expe.pause.public_stops import Stops
from setcmas_simu.ros import qos

REACTION_S = 1.0
"""A press this soon (s) after an automatic pause is not meant as a start; nor is a press this soon
after another, as of a held or bouncing key."""

REPEATS_WITHIN_S = 0.8
"""Longest time after which a held key repeats itself for the first time, in s."""

RELEASED_AFTER_S = 0.3
"""Silence after which a held key or button counts as released, in s."""

RELEASES_WITHIN_S = 3.0
"""Longest time between the two presses that release a stop, in s."""

_LETS_GO_WITHIN_S = 2.0  # until guards and bridge have received a release


class StartRequests:
    """Judges single presses; all times in s on a steady clock."""

    def __init__(self) -> None:
        self._stopped_itself = self._pressed = -math.inf

    def note_pause(self, by_itself: bool, now: float) -> None:
        """Note that the robots paused, automatically or by a person."""
        self._stopped_itself = now if by_itself else -math.inf

    def hasty(self, now: float) -> bool:
        """Note a press; return whether it comes too soon to start robots."""
        before, self._pressed = self._pressed, now
        return now - max(before, self._stopped_itself) < REACTION_S


class HeldStart:
    """Judges the presses of a key or button that must be held; all times in s."""

    def __init__(self) -> None:
        self._pressed = -math.inf
        self._spent = False

    def pressed(self, now: float) -> bool:
        """Note a press; return whether it repeats, so that the key is held."""
        repeated = now - self._pressed < REPEATS_WITHIN_S
        self._spent = self._spent and repeated
        self._pressed = now
        return repeated and not self._spent

    def note_pause(self, now: float) -> None:
        """Note that the robots paused: a held key must be released first."""
        self._spent = not self.released(now)

    def released(self, now: float) -> bool:
        """Return whether nothing is held."""
        return now - self._pressed > RELEASED_AFTER_S


class Emergency:
    """The stop of the pause node; all times in s on a steady clock.

    Attributes:
        why: Its reason; empty if there is none.
    """

    def __init__(self) -> None:
        self.why = ''
        self._asked = self._pressed = self._released = -math.inf

    def stop(self, why: str) -> bool:
        """Stop; return whether that is new."""
        new = not self.why
        self.why = self.why or why
        self._asked = -math.inf
        return new

    def take_over(self, why: str, now: float) -> bool:
        """Take over the stop of a guard or the bridge; return whether that is new."""
        late = now - self._released < _LETS_GO_WITHIN_S
        return not (self.why or late) and self.stop(why)

    @property
    def is_half_released(self) -> bool:
        """Whether the first of the two presses counts."""
        return self._asked > -math.inf

    def release(self, now: float) -> bool:
        """Note a press of the releasing key; return whether it was the second and released.

        A held key repeats itself: its second press spoils the first.
        """
        repeated = now - self._pressed < REPEATS_WITHIN_S
        again = not repeated and now - self._asked < RELEASES_WITHIN_S
        self._asked, self._pressed = -math.inf if repeated else now, now
        if again:
            self.why, self._asked, self._released = '', -math.inf, now
        return again


SILENT_AFTER_S = 0.5
"""Silence at which a joystick counts as gone, in s; it sends 20 messages a second."""


class Joystick:
    """The buttons of a joystick.

    Attributes:
        held: Buttons (the first is 0) that went down and still are.
    """

    def __init__(self) -> None:
        self.held: frozenset[int] = frozenset()
        self._down: frozenset[int] | None = None
        self._last_message = -math.inf

    def pressed(self, buttons: Sequence[int], now: float) -> frozenset[int]:
        """Take a message at a time (s); return the buttons that went down since the last one."""
        self._last_message = now
        down = frozenset(button for button, state in enumerate(buttons) if state)
        new = down - (down if self._down is None else self._down)
        self._down, self.held = down, (self.held & down) | new
        return new

    def disappeared(self, now: float) -> bool:
        """Return, once, whether the joystick has gone silent."""
        if self._down is None or now - self._last_message <= SILENT_AFTER_S:
            return False
        self._down, self.held = None, frozenset()
        return True


_BY = 'by joystick'


class OperatorJoystick:
    """Listens to the joystick's messages."""

    def __init__(
        self,
        node: Node,
        lab: Lab,
        stops: Stops,
        press: Callable[[str], None],
        starts: bool,
        hold: bool,
    ) -> None:
        """Listen through a node.

        Args:
            node: The pause node.
            lab: The joystick's topic and start button.
            stops: Called for any other button.
            press: Called for a press of the start button.
            starts: Whether `setcmas expe` reads a joystick; else joysticks can only stop robots.
            hold: Whether robots move only while the button is held: then every message counts.
        """
        self._node = node
        self._topic, self._button = lab.joystick_topic, lab.joystick_button
        self._stops = stops
        self._press = press
        self._starts = starts
        self._hold = hold
        self._buttons = Joystick()
        node.create_subscription(Joy, self._topic, self._on_joy, qos.SENSOR)

    def disappeared(self) -> bool:
        """Return, once, whether the joystick has gone silent."""
        return self._buttons.disappeared(time.monotonic())

    @property
    def doubt(self) -> str:
        """Why it cannot start robots; empty if it can."""
        if not self._starts:
            return f'this experiment reads no joystick, but {self._topic} is published'
        # Two contradicting joysticks look like a button that is pressed all the time.
        several = self._node.count_publishers(self._topic) > 1
        return f'several nodes publish {self._topic}' if several else ''

    def _on_joy(self, message: Joy) -> None:
        new = self._buttons.pressed(message.buttons, time.monotonic())
        if new - {self._button}:
            self._stops.emergency(_BY)
        elif self._button in (self._buttons.held if self._hold else new):
            self._press(_BY)
        if self._button >= len(message.buttons):
            self._stops.hint(
                f'the joystick has no button {self._button} (its {len(message.buttons)} buttons '
                'count from 0): set joystick.button in the lab file'
            )
