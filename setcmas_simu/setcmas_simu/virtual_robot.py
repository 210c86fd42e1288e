"""A virtual robot: a node that turns cmd_vel into motion, and publishes where the robot is.

`setcmas simu` runs those of a whole fleet in one process. To run one alone (`simulator.py` starts
either):

    ros2 run setcmas_simu virtual_robot --ros-args -r __ns:=/tb3_3 -p x0:=1.0 -p limits:=burger
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from std_msgs.msg import Empty

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports import Failed
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.robots.models_by_name import (
    UNICYCLE,
    check_models,
    is_script,
    robot_models,
)
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import Command, newest_command
from setcmas_simu.ros.parameters import NodeParameters
from setcmas_simu.ros.robot_state import StatePublisher
from setcmas_simu.script_calls import Function, ScriptCall
from setcmas_simu.simulation_options import SimulationOptions

LOOK_EVERY_S = 0.5
"""Time in s between looks for requests to restart, and for displays."""

MOST_SPEED = 1e6
"""Largest speed of a command in m/s, and turn rate in rad/s: beyond, a pose becomes infinite."""

_REST = np.zeros((3, 1))


class VirtualRobot(RobotNode):
    """Integrates the motion of robot i at 10 Hz: cmd_vel in, odom out.

    Attributes:
        state: Rows x, y (m), theta (rad); then, of the last step, speeds forward and to the left
            (m/s) and turn rate (rad/s); shape (6 or more, 1).
        command: Speeds forward and to the left (m/s) and turn rate (rad/s), shape (3, 1).
        model: How a robot of this kind moves, such as a unicycle.
    """

    def __init__(
        self,
        robot: int | None = None,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
        model: str = UNICYCLE,
        options: SimulationOptions | None = None,
        on_failure: Callable[[Failed], object] = bool,
        **of_node: Any,
    ) -> None:
        """Place the robot at x, y in m with a heading in rad; `of_node` is for `RobotNode`.

        `on_failure` is called when a robot script first fails.

        Raises:
            SetcmasError: A parameter is invalid, or the model does not load.
        """
        super().__init__('virtual_robot', robot, follows_clock=False, **of_node)
        options = options or SimulationOptions()
        x, y, theta = start
        x = self.number('x0', x, 'x at the start in m')
        y = self.number('y0', y, 'y at the start in m')
        theta = self.number('theta0', theta, 'heading at the start in rad')
        self.start = np.array([[x], [y], [theta]])
        self.model_name = self.fixed('model', model, 'robot model')
        frame = self.fixed('frame_id', topics.WORLD_FRAME, 'frame of poses')
        own_frame = topics.robot_frame(self.robot)
        own_frame = self.fixed('child_frame_id', own_frame, 'frame of the robot')
        self.parameters = NodeParameters(
            self, options, ('limits', 'cmd_timeout'), check=self.check
        )

        self.cmd_vel = newest_command(self, options.cmd_vel_type)
        self.reset = self.newest(Empty, topics.RESET, qos.EVENT)
        self.on_failure, self.has_started = on_failure, False
        self.next_look = -math.inf
        self.apply(self.parameters.options)
        self.odom = StatePublisher(self, self.robot, frame, own_frame, self.model.shape)
        self.restart()

    def restart(self) -> None:
        """Return to the start; the robot rests there until the next command."""
        self.cmd_vel()  # one that is pending was sent before the restart
        self.state = self.model.start(self.start)
        self.command, self.received_at = _REST, -math.inf

    def step(self) -> None:
        """Follow the newest command for one period, and publish the new state."""
        if self.parameters.options is not self.options:
            self.apply(self.parameters.options)
        if self.time.now >= self.next_look:
            self.look()
        if received := self.cmd_vel():
            self.command, self.received_at = self.checked(received), self.time.now
        if self.has_started:  # the first step only publishes the start
            is_new = self.time.now - self.received_at <= self.timeout
            command = self.command if is_new else _REST
            self.state = self.model.step(self.state, command, self.time.period)
        self.has_started = True
        self.odom.publish(self.state[:6, 0], self.time.stamp)

    def look(self) -> None:
        """Look for rare events: at each step, that would cost as much as the motion."""
        self.next_look = self.time.now + LOOK_EVERY_S
        if self.reset():
            self.restart()
        self.odom.find_displays()

    def checked(self, command: Command) -> Floats:
        """Return a command as an array; zero for one that is not finite, or far too large."""
        V, left, omega = command
        if all(abs(speed) <= MOST_SPEED for speed in command):
            return np.array(command)[:, None]
        self.warn_once(
            'command',
            f'{robot_name(self.robot)} stops: its command on cmd_vel is {V:g}, {left:g} m/s, '
            f'{omega:g} rad/s; each must be at most {MOST_SPEED:g}',
        )
        return _REST

    def check(self, options: SimulationOptions) -> None:
        """Raise SetcmasError if limits would apply to a robot that has its own."""
        check_models([self.model_name], options.limits, [self.robot])

    def apply(self, options: SimulationOptions) -> None:
        """Use these limits and this command time-out from now on."""
        self.options = options
        self.timeout = options.cmd_timeout or math.inf
        if not self.has_started or self.model_name == UNICYCLE:  # others have their own limits
            names = [self.model_name]
            (self.model,) = robot_models(names, [self.robot], options.limits, self.on_warning)

    def on_warning(self, text: str) -> None:
        """Show a warning of a robot script, and report its first failure."""
        self.warn(text)
        if is_script(self.model_name):
            call = ScriptCall(self.robot, Path(self.model_name).name, Function.STEP)
            self.on_failure(Failed(call, text))
            self.on_failure = bool  # does nothing
