"""A virtual robot: a node that turns cmd_vel into motion, and publishes where the robot is.

`setcmas simu` has those of a whole fleet in one process. One alone:

    ros2 run setcmas_simu virtual_robot --ros-args -r __ns:=/tb3_3 -p x0:=1.0 -p limits:=burger
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Empty

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.reports.reports import Failed
from setcmas_simu.reports.script_calls import Function, ScriptCall
from setcmas_simu.robot_node import RobotNode
from setcmas_simu.robots.models import UNICYCLE, check_models, is_script, robot_models, shape_of
from setcmas_simu.ros import qos
from setcmas_simu.ros.cmd_vel_topics import TYPES
from setcmas_simu.ros.robot_state import StatePublisher
from setcmas_simu.simulator.simulator_options import SimulationOptions

MOST_SPEED = 1e6
"""Largest speed of a command in m/s, and turn rate in rad/s: beyond, a pose becomes infinite."""

_REST = np.zeros((3, 1))
_POSE = {'x0': 'x at the start in m', 'y0': 'y in m', 'theta0': 'heading in rad'}


class VirtualRobot(RobotNode):
    """Integrates the motion of robot i at 10 Hz: cmd_vel in, odom out.

    Attributes:
        state: Rows x, y (m), theta (rad); then, of the last step, speeds forward and to the left
            (m/s) and turn rate (rad/s); shape (6 or more, 1).
        command: Speeds forward and to the left (m/s) and turn rate (rad/s), shape (3, 1).
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
        """Place the robot at x, y in m and a heading in rad; `of_node` is for `RobotNode`.

        `on_failure` is called when a robot script first fails.

        Raises:
            SetcmasError: A parameter is invalid, or the model does not load.
        """
        super().__init__('virtual_robot', robot, **of_node)
        options = options or SimulationOptions()
        self.parameters = self.declared(options, 'limits', 'cmd_timeout')
        pose = zip(_POSE, start, _POSE.values(), strict=True)
        self.start = np.array([[self.number(*one)] for one in pose])
        self.model_name = self.fixed('model', model, 'robot model')
        frames = (
            self.fixed('frame_id', topics.WORLD_FRAME, 'frame of poses'),
            self.fixed('child_frame_id', topics.robot_frame(self.robot), 'frame of the robot'),
        )
        self.on_failure, self.moves = on_failure, False
        self.follow(self.parameters.options)
        self.parameters.check, self.parameters.on_change = self.check, self.follow

        self.cmd_vel = self.newest(TYPES[options.cmd_vel_type], topics.CMD_VEL, qos.COMMAND)
        self.reset = self.newest(Empty, topics.RESET, qos.EVENT)
        self.fleet_reset = self.newest(Empty, topics.FLEET_RESET, qos.EVENT)
        self.states = StatePublisher(self, self.robot, *frames, shape_of(self.model_name))
        self.restart()

    def restart(self) -> None:
        """Return to the start; the robot rests there until the next command."""
        self.state = self.model.start(self.start)
        self.command, self.heard = _REST, -math.inf

    def step(self) -> None:
        """Follow the newest command for one period, and publish the new state."""
        if message := self.cmd_vel():
            self.command, self.heard = self.usable(message), self.time.now
        if self.reset() or self.fleet_reset():
            self.restart()
        if self.moves:  # the first step publishes the start
            is_new = self.time.now - self.heard <= self.timeout
            command = self.command if is_new else _REST
            self.state = self.model.step(self.state, command, self.time.period)
        self.moves = True
        self.states.publish(self.state[:6, 0], self.time.stamp)

    def usable(self, message: Twist | TwistStamped) -> Floats:
        """Return the command in a message; zero for one that is not finite, or far too large."""
        twist = message.twist if isinstance(message, TwistStamped) else message
        V, left, omega = command = (twist.linear.x, twist.linear.y, twist.angular.z)
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

    def follow(self, options: SimulationOptions) -> None:
        """Use other limits and another command time-out from now on."""
        self.timeout = options.cmd_timeout or math.inf
        if not self.moves or self.model_name == UNICYCLE:
            names = [self.model_name]
            (self.model,) = robot_models(names, [self.robot], options.limits, self.on_warning)

    def on_warning(self, text: str) -> None:
        """Show a warning of a robot script, and report its first failure."""
        self.warn(text)
        if is_script(self.model_name):
            call = ScriptCall(self.robot, Path(self.model_name).name, Function.STEP)
            self.on_failure(Failed(call, text))
            self.on_failure = bool
