"""Loop of a simulator in lockstep: a step whenever all followers have answered."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.node import Node
from rclpy.subscription import Subscription
from std_msgs.msg import Bool

from setcmas_simu.fleet import topics
from setcmas_simu.lockstep.answer import Answer
from setcmas_simu.lockstep.answer_topic import AnswerTopic
from setcmas_simu.lockstep.roll import Roll
from setcmas_simu.lockstep.ticks import Ticks
from setcmas_simu.messages.arrival import wait_for_any
from setcmas_simu.reports.reports import Paused, Reached
from setcmas_simu.ros import qos
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.simulator.fleet_stepper import FleetStepper
from setcmas_simu.simulator.options import SimulatorOptions
from setcmas_simu.simulator.virtual_robot import VirtualRobot

_WAIT_S = 0.02
_LOOK_EVERY_S = 0.5
_TELL_AFTER_S = 1.5
_TELL_EVERY_S = 0.1
_WINDOW = 20  # steps that a recorder may be behind


class LockstepLoop:
    """Lets time stand until controllers and recorders have answered, and then goes on at once."""

    def __init__(
        self,
        process: RosProcess,
        node: Node,
        stepper: FleetStepper,
        robots: Sequence[VirtualRobot],
        options: SimulatorOptions,
    ) -> None:
        """Listen for answers; time stands at 0.

        Args:
            process: Is served now and then, and says when to stop.
            node: Holds the subscriptions.
            stepper: Moves the robots.
            robots: All robots of the fleet.
            options: How it begins and ends.
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
        self._answers = AnswerTopic(node, self._roll)
        self._paused = False
        self._told = 0.0
        node.create_subscription(Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT)

    def run(self) -> None:
        """Step until the process is to stop."""
        self._node.get_logger().info(
            'in lockstep: time stands at t = 0 until every robot has a controller'
        )
        while not self._process.stopping:
            self._stepper.step(self._ticks.time)
            self._wait(exactly=self._ticks.count == self._nb_steps)
            self._tell_reached()
            if self._ticks.count == self._nb_steps:
                self._process.spin()
            self._ticks.go_to(self._ticks.count + 1)

    def _wait(self, exactly: bool) -> None:
        """Wait until all have answered and their commands are there.

        Args:
            exactly: Whether a recorder is to have everything, too.
        """
        stood = looked = time.monotonic()
        told = ''
        while not self._process.stopping:
            self._answers.take()
            reason, on = self._held_by(exactly)
            if not reason and not self._paused:
                if told:
                    self._node.get_logger().info(f'time goes on from t = {self._ticks.time:g} s')
                return
            wait_for_any(self._node, [on], _WAIT_S)
            now = time.monotonic()
            self._process.serve_at_times()
            stood = now if self._paused else stood
            if now - looked >= _LOOK_EVERY_S:
                looked = now
                if (missing := self._drop_the_dead(exactly)) is not None:
                    told = missing
                    continue
                begun = self._ticks.count > 0 or self._roll.controlled
                if now - stood > _TELL_AFTER_S and reason != told and begun:
                    told = reason
                    self._node.get_logger().warning(
                        f'time stands at t = {self._ticks.time:g} s: waiting for {reason}'
                    )

    def _held_by(self, exactly: bool) -> tuple[str, Subscription]:
        """Return who is waited for, in words, and the subscription that is to bring the answer."""
        stamp = self._ticks.stamp()
        if missing := self._roll.missing(stamp):
            return missing, self._answers.subscription
        if late := self._roll.late(stamp, exactly):
            return _described(late), self._answers.subscription
        for number, commanded in self._roll.commanded().items():
            robot = self._robots.get(number)
            if robot and robot.commanded < commanded:
                robot.take()
                if robot.commanded < commanded:
                    return (
                        f'the command of {topics.robot_name(number)}',
                        robot.commands.subscription,
                    )
        return '', self._answers.subscription

    def _drop_the_dead(self, exactly: bool) -> str | None:
        """Wait no more for processes that have died: they vanish from the graph.

        Returns:
            Who must come now, in words, empty if nobody; None if all are there.
        """
        late = self._roll.late(self._ticks.stamp(), exactly)
        if not late or self._node.count_publishers(topics.LOCKSTEP) >= len(self._roll):
            return None
        self._roll.drop(late)
        missing = self._roll.missing(self._ticks.stamp())
        stands = f'time stands at t = {self._ticks.time:g} s: waiting for {missing}'
        are, it = ('are', 'them') if len(late) > 1 else ('is', 'it')
        self._node.get_logger().warning(
            f'{_described(late)} {are} gone; {stands if missing else f"time goes on without {it}"}'
        )
        return missing

    def _tell_reached(self) -> None:
        now = time.monotonic()
        self._process.serve_at_times()
        if now - self._told >= _TELL_EVERY_S or self._ticks.count == self._nb_steps:
            self._told = now
            self._process.launcher.tell(Reached(self._ticks.time))

    def _on_pause(self, message: Bool) -> None:
        if message.data != self._paused:
            self._paused = message.data
            print('paused by /pause' if message.data else 'started by /pause', flush=True)
            self._process.launcher.tell(Paused(message.data))


def _described(late: Sequence[Answer]) -> str:
    first = late[0].follower
    more = f' and {len(late) - 1} more' if len(late) > 1 else ''
    return f'the {first}{more}'
