"""Loop of a controller in lockstep: answers each state of the robots."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from rclpy.node import Node
from rclpy.qos import QoSProfile

from setcmas_ctrl.controller.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.controller.graph_watch import GraphWatch
from setcmas_ctrl.controller.stepper import ControlStepper
from setcmas_ctrl.driving.odometry import FleetOdometry, State
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Lockstep
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_simu.ros.polling import PolledTopic, wait_for_any
from setcmas_simu.ros.process import FleetNode, RosProcess
from setcmas_simu.simulator.lockstep import Commands, States, Ticks, stamp_at
from setcmas_simu.simulator.lockstep_topics import Answerer, StatesTopic


class LockstepOdometry(FleetOdometry):
    """The newest poses of robots in lockstep.

    Attributes:
        states: The topic with the states of all robots.
    """

    in_lockstep = True

    def _subscribed(self, node: Node, profile: QoSProfile) -> dict[int, PolledTopic]:
        del profile  # the array has its own
        self.states = StatesTopic(node, self._on_states)
        return {}

    def take(self, now: float) -> None:
        """Take the newest states; `now` is the time of the simulation in s."""
        super().take(now)
        self.states.take()

    def _on_states(self, states: States) -> None:
        numbers = states.table[:, 0].astype(int)
        rows = states.table[np.isin(numbers, self._followed)]
        indices = rows[:, 0].astype(int) - 1
        x, y, z, w = rows[:, 1:5].T
        self.stamps[indices] = states.stamp
        self.poses[:, indices] = x, y, yaw_of_quaternion(0.0, 0.0, z, w)
        self._received[indices] = self.now
        for index, row in zip(indices.tolist(), rows[:, 1:].tolist(), strict=True):
            form = self.states.forms.get(self.topic_of(index + 1))
            if form and self._listeners[index]:
                pose = tuple(self.poses[:, index].tolist())
                state = State(pose, row[4], form.at(states.stamp, row))
                for listener in self._listeners[index]:
                    listener(state)


_WAIT_S = 0.02
_SAME_TIME_S = 1e-9
_RECORDER_WAIT_S = 5.0


class LockstepLoop:
    """Calls the control laws at the times of a simulator, as offline runs do."""

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        odometry: LockstepOdometry,
        stepper: ControlStepper,
        broadcasters: Sequence[EventTriggeredComm],
        graph: GraphWatch,
        rate: float,
        announced: Lockstep,
    ) -> None:
        """Give the simulator's time, as announced, to the stepper; `rate` is in Hz."""
        self._process = process
        self._node = node
        self._odometry = odometry
        self._stepper = stepper
        self._broadcasters = broadcasters
        self._nb_steps = announced.nb_steps
        self._ticks = stepper.clock = Ticks(announced.robot_rate)
        self._rate = rate
        self._answerer = Answerer(node, stepper.robots)
        if stepper.communication:
            stepper.communication.in_lockstep = True
        self._graph = graph
        self._recorded = {topics.LOCKSTEP}
        self._nb_publishers = 0
        self._calls = 0
        self._commands: list[Commands] = []
        self._reported = stepper.commands()

    def run(self) -> None:
        """Answer until the process must stop."""
        self._synchronise()
        self._stepper.follow_clock()
        while not self._process.stopping:
            self._await_recorder()
            self._await_sent_states()
            if self._nb_steps is None or self._ticks.count < self._nb_steps:
                self._call_laws()
                self._await_recorder()
            self._answer()
            self._next_tick()

    def leave(self) -> None:
        """Ask the simulator to stop waiting for this process."""
        self._answer(leaves=True)

    def _answer(self, leaves: bool = False) -> None:
        self._add_commands(self._ticks.stamp())
        self._answerer.answer(self._ticks.stamp(), tuple(self._commands), leaves)
        self._commands.clear()

    def _add_commands(self, stamp: int, called: bool = False) -> None:
        """Add the newest commands, if laws were called or robots stopped since the last ones."""
        commands = self._stepper.commands()
        if called:
            self._commands.append(Commands(stamp, commands))
        elif commands != self._reported:  # the laws have no new velocities
            stops = tuple((*row[:3], *[math.nan] * (len(row) - 3)) for row in commands)
            self._commands.append(Commands(stamp, stops))
        self._reported = commands

    def _synchronise(self) -> None:
        """Set the clock to the newest states, and find the next call due."""
        self._ticks.go_to(self._ticks.count_of(int(self._odometry.stamps.max())))
        self._calls = math.ceil(self._ticks.time * self._rate - _SAME_TIME_S)

    def _call_laws(self) -> None:
        end = self._ticks.time + 1 / self._ticks.rate - _SAME_TIME_S
        while (due := self._calls / self._rate) < end:
            self._ticks.time = due
            self._stepper.step(due)
            self._add_commands(stamp_at(due), called=True)
            self._calls += 1

    def _next_tick(self) -> None:
        """Wait for the next states, and take them."""
        waiting = [self._odometry.states.subscription]
        while not self._process.stopping and not wait_for_any(self._node, waiting, _WAIT_S):
            self._process.serve_at_times()
        self._process.serve_at_times()
        if not self._process.stopping:
            self._ticks.go_to(self._ticks.count + 1)
            self._stepper.take()
            if self._odometry.stamps.max() != self._ticks.stamp():
                self._synchronise()  # with a restarted simulator

    def _await_recorder(self) -> None:
        """Wait until the recorder, if there is one, subscribes to new topics of this process."""
        publishers = list(self._node.publishers)
        if len(publishers) == self._nb_publishers:
            return
        # Topics of drawings appear one by one.
        self._nb_publishers = len(publishers)
        published = {self._node.name_in_fleet(one.topic_name): one for one in publishers}
        new = {name for name in published.keys() - self._recorded if self._is_awaited(name)}
        wanted = [published[name] for name in new]
        self._process.spin_until(lambda: self._graph.are_recorded(wanted), _RECORDER_WAIT_S)
        self._recorded |= new

    def _is_awaited(self, name: str) -> bool:
        return '/_' not in name and not topics.is_in_steps(name)

    def _await_sent_states(self) -> None:
        """Wait until this process receives the states that its own robots have sent."""
        communication = self._stepper.communication
        while communication and not self._process.stopping:
            stamps = communication.stamps
            if all(stamps[one.robot - 1] >= one.sent for one in self._broadcasters):
                return
            communication.take()
