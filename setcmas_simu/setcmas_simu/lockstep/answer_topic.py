"""Topic /lockstep: answers of the followers of a simulation."""

from __future__ import annotations

from rclpy.node import Node
from std_msgs.msg import String

from setcmas_simu.fleet import topics
from setcmas_simu.lockstep.answer import NONE, Answer, decode, encode, this_process
from setcmas_simu.lockstep.roll import Roll
from setcmas_simu.messages.polled_topic import PolledTopic
from setcmas_simu.ros import qos


class Answerer:
    """Answers for this process."""

    def __init__(self, node: Node, robots: tuple[int, ...] = ()) -> None:
        """Prepare to answer for controllers of these robots; without robots, for a recorder."""
        self._follower = this_process(robots)
        self._publisher = node.create_publisher(String, topics.LOCKSTEP, qos.LATCHED)

    def answer(self, stamp: int, commanded: int = NONE) -> None:
        """Report that this process has finished with the states of a time, in ns.

        Args:
            stamp: The time.
            commanded: Stamp of the last commands.
        """
        self._send(Answer(self._follower, stamp, commanded))

    def leave(self) -> None:
        """Report that this process stops following."""
        self._send(Answer(self._follower, NONE, leaves=True))

    def _send(self, answer: Answer) -> None:
        self._publisher.publish(String(data=encode(answer)))


class AnswerTopic(PolledTopic):
    """Passes answers to a roll."""

    def __init__(self, node: Node, roll: Roll) -> None:
        """Listen through a node."""
        self._roll = roll
        super().__init__(node, String, topics.LOCKSTEP, self._on_text, qos.LATCHED_BY_MANY)

    def _on_text(self, message: String) -> None:
        if answer := decode(message.data):
            self._roll.take(answer)
