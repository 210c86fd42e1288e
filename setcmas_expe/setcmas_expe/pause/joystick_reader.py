"""Publisher of a joystick as sensor_msgs/Joy, where ROS's joy package is not installed.

Needs pygame. While no joystick is plugged in, nothing is published.
"""

from __future__ import annotations

import argparse
import os
import sys

from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import Joy

from setcmas_simu.errors import needs
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess, node_main

RATE_HZ = 20.0
"""Rate of messages in Hz: the one at which joy_node repeats."""


class JoystickReader(FleetNode):
    """Publishes the first joystick that is plugged in."""

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
