"""Loop of a controller in lockstep: answers each state of the robots."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from setcmas_ctrl.controller.event_triggered_comm import EventTriggeredComm
from setcmas_ctrl.controller.graph_watch import GraphWatch
from setcmas_ctrl.controller.stepper import ControlStepper
from setcmas_ctrl.driving.odometry import FleetOdometry
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.announcement import Lockstep
from setcmas_simu.ros.messages import NO_STAMP
from setcmas_simu.ros.polling import wait_for_any
from setcmas_simu.ros.process import FleetNode, RosProcess
from setcmas_simu.simulator.lockstep import Ticks, stamp_at
from setcmas_simu.simulator.lockstep_topics import Answerer

_WAIT_S = 0.02
_SAME_TIME_S = 1e-9
_RECORDER_WAIT_S = 5.0
_REPEAT_AFTER_S = 1.0


class LockstepLoop:
    """Calls the control laws at the times of a simulator, as offline runs do."""

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        odometry: FleetOdometry,
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
        self._recorded = {node.full_name(topics.LOCKSTEP)}
        self._nb_publishers = 0
        self._calls = 0
        self._commanded = NO_STAMP

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
            self._answerer.answer(self._ticks.stamp(), self._commanded)
            self._next_tick()

    def leave(self) -> None:
        """Ask the simulator to stop waiting for this process."""
        self._answerer.leave()

    def _synchronise(self) -> None:
        """Set the clock to the newest states, and find the next call due."""
        self._ticks.go_to(self._ticks.count_of(int(self._odometry.stamps.max())))
        self._calls = math.ceil(self._ticks.time * self._rate - _SAME_TIME_S)

    def _call_laws(self) -> None:
        end = self._ticks.time + 1 / self._ticks.rate - _SAME_TIME_S
        while (due := self._calls / self._rate) < end:
            self._ticks.time = due
            self._stepper.step(due)
            self._commanded = stamp_at(due)
            self._calls += 1

    def _next_tick(self) -> None:
        """Wait for the next state of every robot, and take it."""
        waiting = [topic.subscription for topic in self._odometry.topics.values()]
        begin, patience = time.monotonic(), _REPEAT_AFTER_S
        while waiting and not self._process.stopping:
            # Wait for the last robot first: the others have usually arrived by then.
            if wait_for_any(self._node, waiting[-1:], _WAIT_S):
                ready = wait_for_any(self._node, waiting, 0.0)
                waiting = [one for i, one in enumerate(waiting) if i not in ready]
            self._process.serve_at_times()
            if waiting and time.monotonic() - begin > patience:
                # On a network that loses packets, DDS may drop a command sent while the simulator
                # and this process discover each other.
                self._stepper.repeat_commands()
                patience *= 2
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
        published = {one.topic_name: one for one in publishers if '/_' not in one.topic_name}
        new = published.keys() - self._recorded
        wanted = [published[name] for name in new]
        self._process.spin_until(lambda: self._graph.are_recorded(wanted), _RECORDER_WAIT_S)
        self._recorded |= new

    def _await_sent_states(self) -> None:
        """Wait until this process receives the states that its own robots have sent."""
        communication = self._stepper.communication
        while communication and not self._process.stopping:
            stamps = communication.stamps
            if all(stamps[one.robot - 1] >= one.sent for one in self._broadcasters):
                return
            communication.take()
