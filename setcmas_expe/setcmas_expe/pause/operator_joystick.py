"""Joystick of the operator: a button that starts and pauses; all others are an emergency stop."""

from __future__ import annotations

import time
from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import Joy

from setcmas_expe.lab.lab import Lab
from setcmas_expe.pause.joystick import Joystick
from setcmas_expe.pause.public_stops import Stops
from setcmas_simu.ros import qos

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
            lab: Which button counts.
            stops: What is done when any other is pressed.
            press: Takes a press of it.
            starts: Whether a joystick is read here; without, one can only stop robots.
            hold: Whether robots move only while it is held: then it counts all the time.
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
        """Return, once, whether a joystick that was there has gone silent."""
        return self._buttons.disappeared(time.monotonic())

    @property
    def doubt(self) -> str:
        """Why it starts nothing; empty if it may."""
        if not self._starts:
            return f'no joystick is read here, but {self._topic} is sent'
        # Two that contradict each other look like a button that is pressed all the time.
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
                f'the joystick has {len(message.buttons)} buttons, counted from 0; button '
                f'{self._button} is not among them: set joystick.button in the lab file'
            )
