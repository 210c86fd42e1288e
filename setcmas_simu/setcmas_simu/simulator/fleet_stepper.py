"""Stepper of a simulator process: moves and publishes all its robots in one step."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from builtin_interfaces.msg import Time
from rclpy.node import Node
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.reports.reports import Failed
from setcmas_simu.reports.script_calls import Function, ScriptCall
from setcmas_simu.robots.models import check_models, fleet_model, is_script, robot_models
from setcmas_simu.robots.virtual_fleet import MOST_SPEED, Command, VirtualFleet
from setcmas_simu.ros import messages, qos
from setcmas_simu.ros.messages import State
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.simulator.lockstep import States
from setcmas_simu.simulator.simulator_options import SimulationOptions
from setcmas_simu.simulator.virtual_robot import FleetTransforms, VirtualRobot

_HOUSEKEEPING_S = 2.0


class FleetStepper:
    """Moves the virtual robots of a process at a fixed rate, in Hz."""

    def __init__(self, node: Node, robots: list[VirtualRobot], options: SimulationOptions) -> None:
        """Connect the robots' commands to a simulated fleet, which moves from the first step on.

        Raises:
            SetcmasError: The model of a robot cannot be loaded.
        """
        self._node = node
        self._robots = robots
        self.on_failure: Callable[[Failed], object] = lambda _: None
        """Called when the script of a robot first fails."""
        self._last_warning = ''
        poses = np.array([robot.pose for robot in robots]).T
        self._names = names = [robot.model for robot in robots]
        self._numbers = numbers = [robot.robot for robot in robots]
        self._limits = options.limits
        models = robot_models(names, numbers, self._limits, self._warn)
        self._scripts = {
            robot: (Path(name).name, model)
            for robot, name, model in zip(numbers, names, models, strict=True)
            if is_script(name)
        }
        self._fleet = VirtualFleet(poses, fleet_model(models), options.cmd_timeout)
        self.rate = options.robot_rate
        for index, robot in enumerate(robots):
            robot.on_command = partial(self._command, index)
            robot.on_reset = partial(self._fleet.reset, index)
        node.create_service(Trigger, '~/reset', self._answer_reset)
        self._resets = PolledTopic(node, Empty, topics.FLEET_RESET, self._reset_all, qos.EVENT)
        self._transforms = FleetTransforms(node, [robot.frames for robot in robots])
        self._refused: set[int] = set()
        self._missed = 0
        self._now = 0.0
        self._published: tuple[int, list[State]] = (messages.NO_STAMP, [])
        self._last_step: float | None = None
        self._next_housekeeping = -math.inf
        self.publish_time: Callable[[Time], object] = lambda _: None
        """Called with the stamp of each step before its states are published."""
        self.publish_states: Callable[[States], object] = lambda _: None
        """Called with the states of each step before the robots publish theirs."""
        self.housekeeping: Callable[[], None] = lambda: None
        """Called every two seconds of real time."""

    @property
    def period(self) -> float:
        """Time in s between steps."""
        return 1.0 / self.rate

    def check(self, options: SimulationOptions) -> None:
        """Raise SetcmasError if limits would apply to other models."""
        check_models(self._names, options.limits, self._numbers)

    def follow(self, options: SimulationOptions) -> None:
        """Use other options from now on: rate, limits and command time-out."""
        self.rate = options.robot_rate
        self._last_step = None
        model = self._fleet.model
        if options.limits != self._limits:  # all are unicycles
            self._limits = options.limits
            model = fleet_model(robot_models(self._names, self._numbers, self._limits))
        self._fleet.use(model, options.cmd_timeout)

    def log_robots(self) -> None:
        """Log which robots are simulated."""
        robots = robots_in_words(self._numbers)
        self._node.get_logger().info(f'simulating {robots} at {self.rate:g} Hz; Ctrl-C stops')

    def step(self, now: float) -> None:
        """Take commands, move the robots by one period, and publish their states; `now` is in s.

        The first step publishes the start poses.
        """
        self._take(now)
        if self._last_step is not None:
            self._fleet.step(self.period, now)
        self._report_failures()
        stamp = messages.stamp()
        self.publish_time(stamp)
        x, y, theta = self._fleet.poses
        columns = np.array([x, y, *quaternion_of_yaw(theta), *self._fleet.twists])
        states: list[State] = columns.T.tolist()
        stamp_ns = stamp.sec * 10**9 + stamp.nanosec
        self.publish_states(States(stamp_ns, np.vstack([self._numbers, columns]).T))
        # All odometry in one burst first: controllers then wake up less often.
        for robot, state in zip(self._robots, states, strict=True):
            robot.publish_odometry(stamp_ns, state)
        for robot, state in zip(self._robots, states, strict=True):
            robot.publish_picture(stamp_ns, state)
        self._transforms.publish(stamp, states)
        self._published = stamp_ns, states
        self._count_missed_steps(now)
        self.keep_house()

    def keep_house(self) -> None:
        """Look around every two seconds of real time, also while time waits in lockstep."""
        if (real := time.monotonic()) >= self._next_housekeeping:
            self._next_housekeeping = real + _HOUSEKEEPING_S
            self._report_missed_steps()
            self.housekeeping()

    def publish_to_newcomers(self) -> None:
        """Publish the states of the last step to those who have subscribed since."""
        stamp_ns, states = self._published
        for robot, state in zip(self._robots, states, strict=False):
            robot.publish_to_newcomers(stamp_ns, state)

    def _take(self, now: float) -> None:
        self._now = now
        for robot in self._robots:
            robot.take()
        self._resets.take()

    def _command(self, index: int, command: Command) -> None:
        if not self._fleet.command(index, command, self._now) and index not in self._refused:
            self._refused.add(index)
            V, left, omega = command
            self._node.get_logger().warning(
                f'{topics.robot_name(self._numbers[index])} stops: its command on cmd_vel is '
                f'{V:g}, {left:g} m/s, {omega:g} rad/s; each must be at most {MOST_SPEED:g}'
            )

    def _warn(self, text: str) -> None:
        self._node.get_logger().warning(text)
        self._last_warning = text

    def _report_failures(self) -> None:
        for robot, (script, model) in list(self._scripts.items()):
            if model.failed:
                del self._scripts[robot]
                call = ScriptCall(robot, script, Function.STEP)
                self.on_failure(Failed(call, self._last_warning))

    def _count_missed_steps(self, now: float) -> None:
        if self._last_step is not None:
            self._missed += max(0, round((now - self._last_step) / self.period) - 1)
        self._last_step = now

    def _report_missed_steps(self) -> None:
        if self._missed:
            steps = 'step was' if self._missed == 1 else 'steps were'
            self._node.get_logger().warning(
                f'{self._missed} {steps} missed in the last {_HOUSEKEEPING_S:g} s: '
                'this machine is too busy for the simulation'
            )
            self._missed = 0

    def _reset_all(self, _: Empty) -> None:
        for index in range(len(self._robots)):
            self._fleet.reset(index)

    def _answer_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._reset_all(Empty())
        response.success, response.message = True, 'all robots are back at their start poses'
        return response
