"""Loop of a simulator in lockstep: steps as soon as all followers have answered."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_simu.fleet import topics
from setcmas_simu.reports.reports import Paused, Reached
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import wait_for_any
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.simulator.fleet_stepper import FleetStepper
from setcmas_simu.simulator.lockstep import Answer, Roll, Ticks
from setcmas_simu.simulator.lockstep_topics import AnswerTopic, StatesPublisher
from setcmas_simu.simulator.simulator_options import SimulatorOptions
from setcmas_simu.simulator.virtual_robot import VirtualRobot

_WAIT_S = 0.02
_LOOK_EVERY_S = 0.5
_REPORT_WAIT_AFTER_S = 1.5
_REPORT_TIME_EVERY_S = 0.1
_WINDOW = 20  # steps that a recorder may lag behind


class LockstepLoop:
    """Advances time as soon as controllers and recorders have answered."""

    def __init__(
        self,
        process: RosProcess,
        node: Node,
        stepper: FleetStepper,
        robots: Sequence[VirtualRobot],
        options: SimulatorOptions,
    ) -> None:
        """Subscribe to answers; time is 0.

        Args:
            process: Served now and then; ends the loop when it stops.
            node: Holds the subscriptions.
            stepper: Moves the robots.
            robots: All robots of the fleet.
            options: Conditions for the start and the end.
        """
        self._process = process
        self._node = node
        self._stepper = stepper
        self._robots = {robot.robot: robot for robot in robots}
        self._nb_steps = options.nb_steps
        self._ticks = Ticks(stepper.rate)
        self._roll = Roll(
            list(self._robots), options.recorded, round(_WINDOW * 1e9 / stepper.rate)
        )
        self._answers = AnswerTopic(node, self._on_answer)
        forms = {name: form for robot in robots for name, form in robot.forms.items()}
        stepper.publish_states = StatesPublisher(node, forms).publish
        self._paused = False
        self._reported_at = 0.0
        node.create_subscription(Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT)

    def run(self) -> None:
        """Step until the process must stop."""
        self._node.get_logger().info(
            'in lockstep: time waits at t = 0 until every robot has a controller'
        )
        while not self._process.stopping:
            self._stepper.step(self._ticks.time)
            self._wait(exactly=self._ticks.count == self._nb_steps)
            self._report_time()
            if self._ticks.count == self._nb_steps:
                self._process.spin_until(lambda: False, math.inf)  # looks for signals often
            self._ticks.go_to(self._ticks.count + 1)

    def _wait(self, exactly: bool) -> None:
        """Wait until all followers have answered.

        Args:
            exactly: Whether recorders, too, must have finished.
        """
        since = looked = time.monotonic()
        reported = ''
        while not self._process.stopping:
            self._answers.take()
            left = self._roll.left()
            # The last one usually leaves because all processes end.
            if left and not self._roll.missing(self._ticks.stamp()):
                self._report_without(left, 'left')
            reason = self._awaited(exactly)
            if not reason and not self._paused:
                if reported:
                    self._node.get_logger().info(f'time advances from t = {self._ticks.time:g} s')
                return
            wait_for_any(self._node, [self._answers.subscription], _WAIT_S)
            now = time.monotonic()
            self._process.serve_at_times()
            since = now if self._paused else since
            if now - looked >= _LOOK_EVERY_S:
                looked = now
                self._stepper.publish_to_newcomers()
                self._stepper.keep_house()
                if (missing := self._drop_the_dead(exactly)) is not None:
                    reported = missing
                    continue
                begun = self._ticks.count > 0 or self._roll.controlled
                if now - since > _REPORT_WAIT_AFTER_S and reason != reported and begun:
                    reported = reason
                    self._node.get_logger().warning(
                        f'time waits at t = {self._ticks.time:g} s for {reason}'
                    )

    def _on_answer(self, answer: Answer) -> None:
        """Command the robots of a follower.

        Other stamps than the newest belong to an earlier simulator.
        """
        self._roll.take(answer)
        if answer.commands and (answer.leaves or answer.stamp == self._ticks.stamp()):
            newest = answer.commands[-1].rows
            for number, command in zip(answer.follower.robots, newest, strict=True):
                if number in self._robots and not math.isnan(command[0]):
                    self._robots[number].on_command((command[0], command[1], command[2]))

    def _awaited(self, exactly: bool) -> str:
        """Return the missing answer, as text; '' if none is."""
        stamp = self._ticks.stamp()
        if missing := self._roll.missing(stamp):
            return missing
        late = self._roll.late(stamp, exactly)
        return _described(late) if late else ''

    def _drop_the_dead(self, exactly: bool) -> str | None:
        """Stop waiting for processes that have died, which vanish from the graph.

        Returns:
            Who must replace them, as text, '' if no process; None if all are alive.
        """
        late = self._roll.late(self._ticks.stamp(), exactly)
        if not late or self._node.count_publishers(topics.LOCKSTEP) >= len(self._roll):
            return None
        self._roll.drop(late)
        return self._report_without(late, 'vanished')

    def _report_without(self, gone: Sequence[Answer], how: str) -> str:
        """Report followers that are gone; return who must replace them, '' if no process."""
        missing = self._roll.missing(self._ticks.stamp())
        waits = f'time waits at t = {self._ticks.time:g} s for {missing}'
        have, it = ('have', 'them') if len(gone) > 1 else ('has', 'it')
        goes_on = f'time advances without {it}'
        self._node.get_logger().warning(
            f'{_described(gone)} {have} {how}; {waits if missing else goes_on}'
        )
        return missing

    def _report_time(self) -> None:
        now = time.monotonic()
        self._process.serve_at_times()
        if now - self._reported_at >= _REPORT_TIME_EVERY_S or self._ticks.count == self._nb_steps:
            self._reported_at = now
            self._process.launcher.report(Reached(self._ticks.time))

    def _on_pause(self, message: Bool) -> None:
        if message.data != self._paused:
            self._paused = message.data
            print('paused by /pause' if message.data else 'started by /pause', flush=True)
            self._process.launcher.report(Paused(message.data))


def _described(late: Sequence[Answer]) -> str:
    first = late[0].follower
    more = f' and {len(late) - 1} more' if len(late) > 1 else ''
    return f'the {first}{more}'
