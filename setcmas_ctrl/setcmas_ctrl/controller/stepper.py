"""Stepper of a controller process: calls the laws of all its robots, and commands them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from functools import partial
from itertools import repeat

import numpy as np
from rclpy.node import Node

from setcmas_ctrl.control.commander import Commanded, Commander
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.control_options import GainOptions
from setcmas_ctrl.controller.graph_watch import GraphWatch
from setcmas_ctrl.controller.network_links import FleetCommunication
from setcmas_ctrl.controller.script_outcomes import ScriptOutcomes
from setcmas_ctrl.driving.driven_robot import Controller, SiToUni
from setcmas_ctrl.driving.fleet_discovery import LostRobots, wait_until
from setcmas_ctrl.driving.fleet_pause import PauseWatch
from setcmas_ctrl.driving.fleet_time import FleetTime, FleetTimeTopic
from setcmas_ctrl.driving.odometry import POSE_TIMEOUT_S, FleetOdometry
from setcmas_ctrl.scripts.script_errors import ControlError, StopCall
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.fleet.topics import TRIG_ODOM, robot_topic
from setcmas_simu.reports.reports import Started
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.ros.step_loop import Clock, SteadyClock

_NO_COMMAND = (math.nan, 0.0, math.nan)
_POLL_EVERY_S = 0.002
_AFTER_ODOMETRY_S = 0.02
_OFFERED_WITHIN_S = 0.5  # a reliable driver has usually published by then
_LISTENERS_WAIT_S = 2.0
_ENDS_ALL = 'this process exits: it can no longer command any robot'
_RECORDER_WAIT_S = 15.0  # enough for a machine that loads everything from disk first


class ControlStepper:
    """Calls the control laws at a fixed rate, all with the same poses and time."""

    def __init__(
        self,
        node: Node,
        odometry: FleetOdometry,
        robots: list[tuple[Controller, SiToUni]],
        commander: Commander,
        outcomes: ScriptOutcomes,
        graph: GraphWatch,
        pause: PauseWatch | None = None,
    ) -> None:
        """Prepare; the first step makes the first call.

        In an experiment `pause` pauses the laws; in a simulation they pause while all robots are
        paused. During a pause t does not advance.
        """
        self._node = node
        self._odometry = odometry
        self._controllers = [controller for controller, _ in robots]
        self._drivers = [driver for _, driver in robots]
        self._commander = commander
        self.clock: Clock = SteadyClock()
        self._pause = pause
        self._warn = node.get_logger().warning
        self._has_laws = True
        self.watch = outcomes.watch
        self.outcomes = outcomes
        self._time = FleetTime()
        self._time_topic = None
        if len(robots) < odometry.poses.shape[1]:  # other processes may control the others
            own = list(self.robots)
            self._time_topic = FleetTimeTopic(node, own, self._time, lambda: self.clock.now())
        self.communication: FleetCommunication | None = None
        """Links and messages of the robots; None before they are connected."""
        self._stepped = 0.0
        self._graph = graph
        self._lost = LostRobots(self.robots, odometry, self._warn)
        self._take_signals: Callable[[], None] = lambda: None

    def get_ready(
        self, process: RosProcess, recorded: bool = False, lockstep: bool = False
    ) -> None:
        """Wait until all poses are known and the robots listen, and the recorder if there is one.

        In lockstep the robots wait for the laws, so the clocks need no synchronising.
        """
        odometry = self._odometry
        process.spin_until(lambda: not self._taken(odometry.missing), _OFFERED_WITHIN_S)
        odometry.accept_best_effort(odometry.missing())
        self._await(process, 'odometry', odometry.missing, odometry.topic_of, self._odometry_hint)
        if self.links:
            state_of = partial(robot_topic, topic=TRIG_ODOM)
            self._await(process, 'states', self.links.missing, state_of, _sent_hint)
        # The robots, and a recorder if there is one, must get the very first command.
        process.spin_until(self._graph.all_connected(), _LISTENERS_WAIT_S)
        wait_s = _RECORDER_WAIT_S if recorded else _LISTENERS_WAIT_S
        process.spin_until(self._graph.all_recorded(recorded), wait_s)
        if self._time_topic and not lockstep:
            self._time_topic.wait_for_others(process)
        if process.stopping:
            return
        # Log now, not between the odometry and t = 0: logging takes time.
        law = ', '.join(dict.fromkeys(each.law.path.stem for each in self._controllers))
        self._node.get_logger().info(
            f'controlling {robots_in_words(list(self.robots))} with {law} '
            f'at {self._commander.gains.rate:g} Hz; Ctrl-C stops'
        )
        process.launcher.report(Started(self.robots, law))
        self._take_signals = process.take_signals
        if not lockstep:
            self._fall_in_step(process)
        self._stepped = self.clock.now()

    def _await(
        self,
        process: RosProcess,
        what: str,
        missing: Callable[[], list[int]],
        topic_of: Callable[[int], str],
        hint: Callable[[list[int]], str],
    ) -> None:
        """Wait until no robot is missing; name those that are, now and then, with a hint."""

        def remind() -> None:
            robots = missing()
            text = f'waiting for the {what} of {robots_in_words(robots)} ({topic_of(robots[0])})'
            self._warn(f'{text}; {hint(robots)}')

        wait_until(process, lambda: not self._taken(missing), remind)

    def _taken(self, missing: Callable[[], list[int]]) -> list[int]:
        self.take()
        return missing()

    def _odometry_hint(self, robots: list[int]) -> str:
        self._odometry.accept_best_effort(robots)
        for robot in robots:
            if fault := self._odometry.fault(robot):
                return f'robot {robot} sends invalid odometry: {fault}'
        if self._pause:
            return f'does motion capture see {"it" if len(robots) == 1 else "them"}?'
        return 'is the simulator running?'

    def _fall_in_step(self, process: RosProcess) -> None:
        """Wait until shortly after the next odometry of a robot.

        Robots and laws step on clocks that run alike, at rates that divide each other, so that
        from then on every call sees fresh poses, and its commands arrive before the robots' next
        step.
        """
        self.take()

        def is_new() -> bool:
            self.take()
            return self._odometry.age(self.robots[0]) == 0.0

        process.spin_until(is_new, 1.0, _POLL_EVERY_S)
        begin = self.clock.now()
        process.spin_until(
            lambda: self.clock.now() - begin >= _AFTER_ODOMETRY_S, 1.0, _POLL_EVERY_S
        )

    @property
    def robots(self) -> tuple[int, ...]:
        """The robots of this process."""
        return tuple(controller.robot for controller in self._controllers)

    def follow_clock(self) -> None:
        """Use the clock's time as t, as other processes do."""
        self._time.follow_clock()

    @property
    def links(self) -> FleetCommunication | None:
        """What each robot knows of the fleet; None if all robots know all poses."""
        return self.communication if self.communication and self.communication.is_on else None

    @property
    def t(self) -> float:
        """Time t of the control laws in s: 0 before their first call, constant while paused."""
        return self._time.at(self.clock.now())

    @property
    def shares_t(self) -> bool:
        """Whether other processes use the same t."""
        return self._time.is_shared(self.clock.now())

    def use(self, laws: list[ControlLaw]) -> None:
        """Replace the laws, and reset t and errors; without laws all robots stop."""
        self.outcomes.begin_anew(loaded=laws != [])
        self._has_laws = laws != []
        for controller, law in zip(self._controllers, laws, strict=False):
            controller.law = law
        self._time.begin_anew()
        if self.links:
            self.links.forget_messages()

    def follow(self, gains: GainOptions) -> None:
        """Use other gains from now on."""
        self._commander.gains = gains

    def commands(self) -> tuple[tuple[float, ...], ...]:
        """Return the last commands of all robots, as answers in lockstep carry them."""
        return tuple(
            (*driver.sent, *controller.wanted[:2], *controller.allowed)
            for controller, driver in zip(self._controllers, self._drivers, strict=True)
        )

    def stop(self) -> None:
        """Command zero to every robot."""
        for driver in self._drivers:
            driver.stop()
        for driver in self._drivers:
            driver.cmd_vel.wait_until_sent()
        if self.links:
            self.links.stop()

    def take(self) -> None:
        """Take pending messages: poses, pause requests, states that robots have sent."""
        self._take(self.clock.now())

    def step(self, now: float) -> None:
        """Take messages, call the laws, and command the robots; `now` is in s."""
        self._take(now)
        # A step cannot receive odometry while it runs.
        self._lost.update(POSE_TIMEOUT_S + now - self._stepped)
        with self.watch.step():
            paused = self._is_paused()
            t = self._time.step(now, paused)
            if paused:  # laws are not called, so that references do not run ahead
                self._command(self._commander.stop())
            else:
                self._control(t)
        if self._time_topic:
            self._time_topic.publish()
        self._stepped = now
        self._take_signals()  # scripts may have changed the handlers
        self._graph.check()

    def _take(self, now: float) -> None:
        if self.communication:
            self.communication.take_values()
        self._odometry.take(now)
        if self.communication:
            self.communication.take()
        for driver in self._drivers:
            driver.take()

    def _is_paused(self) -> bool:
        if self._pause:
            return self._pause.reason() != ''
        return all(driver.paused for driver in self._drivers)

    def _control(self, t: float) -> None:
        poses: Iterable[Floats] = repeat(self._odometry.poses.copy())
        adjacency = None
        if self.communication:
            self.communication.t = t
        if self.links:
            poses, adjacency = self.links.known_poses(t)
        velocities, idle = [], set()
        for controller, known in zip(self._controllers, poses, strict=False):
            velocity = None
            if self._has_laws and controller.robot not in self._lost:
                try:
                    with self.watch.call(controller.robot, controller.law.path):
                        velocity = controller.law(known, t, adjacency)
                    self._check_ros(controller, t)
                    self.outcomes.laws.succeeded(controller.robot, t)
                except ControlError as error:
                    self.outcomes.laws.failed(controller.robot, t, error)
            velocities.append(velocity or (0.0, 0.0))
            if velocity is None:
                idle.add(controller.robot)
        self._commander.use([driver.model for driver in self._drivers])
        wanted = np.array(velocities).T
        self._command(self._commander(wanted, self._odometry.poses), idle)

    def _command(self, commanded: Commanded, idle: Collection[int] = ()) -> None:
        """Publish wanted and allowed velocities, and command the robots."""
        for controller, velocity in zip(
            self._controllers, commanded.wanted.T.tolist(), strict=True
        ):
            controller.publish(*velocity)
        if commanded.allowed is not None:
            for controller, allowed in zip(
                self._controllers, commanded.allowed.T.tolist(), strict=True
            ):
                controller.publish_allowed(*allowed)
        for driver, command in zip(self._drivers, commanded.commands.T.tolist(), strict=True):
            # A failing law differs from a law that returns zero: in an experiment the bridge
            # stops the robot until a person starts it again.
            has_failed = self._pause is not None and driver.robot in idle
            driver.command(*(_NO_COMMAND if has_failed else command))

    def _check_ros(self, controller: Controller, t: float) -> None:
        """Check that no script has shut down ROS in this process.

        Raises:
            StopCall: ROS is shut down; the process ends.
        """
        if not self._node.context.ok():
            name = controller.law.path.name
            text = f'{name} has shut ROS down (rclpy.shutdown)'
            error = ControlError(text, 'shutdown', _ENDS_ALL)
            self.outcomes.laws.failed(controller.robot, t, error)
            raise StopCall


def _sent_hint(_: list[int]) -> str:
    return 'is a controller running with --event-triggered?'
