"""Joystick of the operator: one button starts robots, all others are a stop.

Run as `ros2 run setcmas_expe joystick_reader`, it publishes the joystick as sensor_msgs/Joy with
pygame, where ROS's joy package is not installed.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import time
from collections.abc import Callable, Sequence

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import Joy

from setcmas_expe.lab.lab import Lab
from setcmas_simu.errors import needs
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess, node_main

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


class OperatorJoystick(Joystick):
    """Listens to the joystick's messages."""

    def __init__(
        self,
        node: Node,
        lab: Lab,
        press: Callable[[str], None],
        stop: Callable[[str], None],
        hint: Callable[[str], None],
        starts: bool,
        hold: bool,
    ) -> None:
        """Listen through a node.

        Args:
            node: The pause node.
            lab: The joystick's topic and start button.
            press: Called for a press of the start button.
            stop: Called for any other button.
            hint: Called with why the start button does nothing.
            starts: Whether `setcmas expe` reads a joystick; else joysticks can only stop robots.
            hold: Whether robots move only while the button is held: then every message counts.
        """
        super().__init__()
        self._node = node
        self._topic, self._button = lab.joystick_topic, lab.joystick_button
        self._press, self._stop, self._hint = press, stop, hint
        self._starts = starts
        self._hold = hold
        node.create_subscription(Joy, self._topic, self._on_joy, qos.SENSOR)

    @property
    def doubt(self) -> str:
        """Why it cannot start robots; empty if it can."""
        if not self._starts:
            return f'this experiment reads no joystick, but {self._topic} is published'
        # Two contradicting joysticks look like a button that is pressed all the time.
        several = self._node.count_publishers(self._topic) > 1
        return f'several nodes publish {self._topic}' if several else ''

    def _on_joy(self, message: Joy) -> None:
        new = self.pressed(message.buttons, time.monotonic())
        if new - {self._button}:
            self._stop(_BY)
        elif self._button in (self.held if self._hold else new):
            self._press(_BY)
        if self._button >= len(message.buttons):
            self._hint(
                f'the joystick has no button {self._button} (its {len(message.buttons)} buttons '
                'count from 0): set joystick.button in the lab file'
            )


RATE_HZ = 20.0
"""Rate of messages in Hz: the one at which joy_node repeats."""


class JoystickReader(FleetNode):
    """Publishes the first joystick that is plugged in; nothing while there is none."""

    def __init__(self) -> None:
        """Create the node; the joystick may be plugged in later."""
        super().__init__('joystick_reader')
        # SDL asks for a window and its focus by default.
        os.environ.setdefault('SDL_VIDEODRIVER', 'dummy')
        os.environ.setdefault('SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS', '1')
        os.environ.setdefault('PYGAME_HIDE_SUPPORT_PROMPT', '1')
        with needs('lab'):
            import pygame

        self._pygame = pygame
        pygame.display.init()
        pygame.joystick.init()
        self._joystick: pygame.joystick.JoystickType | None = None
        self._publisher = self.create_publisher(Joy, 'joy', qos.STATE)
        self._message = Joy()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / RATE_HZ, self._read, clock=steady)

    def _read(self) -> None:
        self._pygame.event.pump()
        count = self._pygame.joystick.get_count()
        if not count:
            self._joystick = None
        elif self._joystick is None or not self._joystick.get_init():
            self._joystick = self._pygame.joystick.Joystick(0)
            self.get_logger().info(f'joystick: {self._joystick.get_name()}')
        if self._joystick is None:
            return
        stick, message = self._joystick, self._message
        message.header.stamp = self.get_clock().now().to_msg()
        message.axes = [stick.get_axis(i) for i in range(stick.get_numaxes())]
        message.buttons = [stick.get_button(i) for i in range(stick.get_numbuttons())]
        self._publisher.publish(message)


def main(argv: list[str] | None = None) -> int:
    """Publish until a signal arrives; return the exit status."""
    parser = argparse.ArgumentParser(prog='joystick_reader', description=__doc__)
    return node_main(parser, _read, argv)


def _read(process: RosProcess, _: argparse.Namespace) -> None:
    process.add(JoystickReader())
    process.spin()


if __name__ == '__main__':
    sys.exit(main())
