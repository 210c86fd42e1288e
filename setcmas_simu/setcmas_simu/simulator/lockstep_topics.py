"""Topics of a simulation in lockstep: /lockstep and /clock."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int64MultiArray

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import NO_STAMP
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.simulator.lockstep import Answer, Roll, decode, encode, this_process

_WARN_EVERY_S = 10.0


class Answerer:
    """Answers for this process."""

    def __init__(self, node: Node, robots: tuple[int, ...] = ()) -> None:
        """Prepare to answer for controllers of these robots; without robots, for a recorder."""
        self._follower = this_process(robots)
        self._publisher = node.create_publisher(Int64MultiArray, topics.LOCKSTEP, qos.LATCHED)

    def answer(self, stamp: int, commanded: int = NO_STAMP) -> None:
        """Report that this process has finished with the states of a time, in ns.

        Args:
            stamp: The time.
            commanded: Stamp of the last commands.
        """
        self._send(Answer(self._follower, stamp, commanded))

    def leave(self) -> None:
        """Report that this process stops following."""
        self._send(Answer(self._follower, NO_STAMP, leaves=True))

    def _send(self, answer: Answer) -> None:
        self._publisher.publish(Int64MultiArray(data=encode(answer)))


class AnswerTopic(PolledTopic):
    """Passes answers to a roll."""

    def __init__(self, node: Node, roll: Roll) -> None:
        self._roll = roll
        self._warn = node.get_logger().warning
        super().__init__(
            node, Int64MultiArray, topics.LOCKSTEP, self._on_numbers, qos.LATCHED_BY_MANY
        )

    def _on_numbers(self, message: Int64MultiArray) -> None:
        try:
            self._roll.take(decode(message.data))
        except ValueError as error:
            topic = self.subscription.topic_name
            self._warn(
                f'ignored a message on {topic}: {error}', throttle_duration_sec=_WARN_EVERY_S
            )


class ClockTopic:
    """Publishes the time of a simulation."""

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(Clock, topics.CLOCK, qos.LOCKSTEP_STATE)

    def publish(self, stamp: Time) -> None:
        """Publish a time."""
        self._publisher.publish(Clock(clock=stamp))
