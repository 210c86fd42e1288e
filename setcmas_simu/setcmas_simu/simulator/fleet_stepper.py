"""Stepper of a simulator process: one timer that moves and publishes all its robots."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Empty

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import format_robots
from setcmas_simu.options.kinds import MAX_RATE_HZ
from setcmas_simu.reports.reports import Failed, Function, ScriptCall
from setcmas_simu.robots.mixed_fleet import fleet_model
from setcmas_simu.robots.models import is_script, robot_models
from setcmas_simu.robots.virtual_fleet import VirtualFleet
from setcmas_simu.ros import qos
from setcmas_simu.simulator.transforms import FleetTransforms
from setcmas_simu.simulator.virtual_robot import VirtualRobot

_HOUSEKEEPING_S = 2.0


class FleetStepper:
    """Moves the virtual robots of a process at a fixed rate.

    A timer for each robot would wake the executor N times a period, and rclpy rebuilds its wait
    set over all entities at every wake-up.
    """

    def __init__(self, node: Node, robots: list[VirtualRobot]) -> None:
        """Connect the robots' commands to a simulated fleet; nothing moves before `start`.

        Args:
            node: The node that owns the timer and what concerns the whole fleet.
            robots: The robots; rate, limits and cmd_timeout are the first one's parameters.

        Raises:
            SetcmasError: A parameter of a robot makes no sense, or its model cannot be loaded.
        """
        self._node = node
        self._robots = robots
        self.on_failure: Callable[[Failed], object] = lambda _: None
        """Called when the script of a robot has failed for the first time."""
        self._last_words = ''
        far = 1e6  # m, rad: excludes what is not finite
        start = ('x0', 'y0', 'theta0')
        poses = np.array([[robot.number(name, -far, far) for name in start] for robot in robots]).T
        names = [str(robot.value('model')) for robot in robots]
        numbers = [robot.robot for robot in robots]
        limits = str(robots[0].value('limits'))
        models = robot_models(names, numbers, limits, self._warn)
        self._scripts = {
            robot: (Path(name).name, model)
            for robot, name, model in zip(numbers, names, models, strict=True)
            if is_script(name)
        }
        timeout = robots[0].number('cmd_timeout', least=1e-3)
        self._fleet = VirtualFleet(poses, fleet_model(models), timeout)
        self._period = 1.0 / robots[0].number('rate', least=0.1, most=MAX_RATE_HZ)
        for index, robot in enumerate(robots):
            robot.on_command = partial(self._fleet.command, index)
            robot.on_reset = partial(self._fleet.reset, index)
        node.create_subscription(
            Empty,
            topics.FLEET_RESET,
            self._reset_all,
            qos.EVENT,
        )
        self._transforms = FleetTransforms(
            node, [(str(r.value('world_frame')), str(r.value('robot_frame'))) for r in robots]
        )
        self._missed = 0
        self._last_step: float | None = None
        self._next_housekeeping = 0.0
        self._housekeeping: Callable[[], None] = lambda: None

    def start(self, housekeeping: Callable[[], None]) -> None:
        """Start to step; `housekeeping` is called every other second."""
        self._housekeeping = housekeeping
        # A steady clock: setting the system's time must not freeze the robots.
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._node.create_timer(self._period, self._step, clock=steady)
        robots = format_robots([robot.robot for robot in self._robots])
        self._node.get_logger().info(
            f'simulating robots {robots} at {1 / self._period:g} Hz; Ctrl-C stops'
        )
        self._step()

    def _step(self) -> None:
        now = time.monotonic()
        self._fleet.step(self._period, now)
        self._tell_failures()
        stamp = self._node.get_clock().now().to_msg()
        poses = list(map(tuple, self._fleet.poses.T.tolist()))
        twists = map(tuple, self._fleet.twists.T.tolist())
        # All odometries first and in one burst: what controls the robots wakes up less often.
        for robot, pose, twist in zip(self._robots, poses, twists, strict=True):
            robot.publish_odometry(stamp, pose, twist)
        for robot, pose in zip(self._robots, poses, strict=True):
            robot.publish_picture(stamp, pose)
        self._transforms.publish(stamp, self._fleet.poses)
        self._count_missed_steps(now)
        if now >= self._next_housekeeping:
            self._next_housekeeping = now + _HOUSEKEEPING_S
            self._report_missed_steps()
            self._housekeeping()

    def _warn(self, text: str) -> None:
        self._node.get_logger().warning(text)
        self._last_words = text

    def _tell_failures(self) -> None:
        for robot, (script, model) in list(self._scripts.items()):
            if model.failed:
                del self._scripts[robot]
                call = ScriptCall(robot, script, Function.STEP)
                self.on_failure(Failed(call, self._last_words))

    def _count_missed_steps(self, now: float) -> None:
        if self._last_step is not None:
            self._missed += max(0, round((now - self._last_step) / self._period) - 1)
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
