"""Topics with the values that control laws send, for controllers of other robots and recorders.

A std_msgs/Float64MultiArray on /tb3_i/message: first the time t of the call in s, then, from the
layout's data_offset on, the numbers of the value. The dimensions of its layout are those of
`message_content.layout`: equal labels name the value that they belong to, stride 0 is a number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Float64MultiArray, MultiArrayDimension

from setcmas_ctrl.communication.message_content import Content, content_of, layout
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic


class MessageTopics:
    """Publishes what robots of this process send, and takes what all others send.

    Nothing is published or subscribed before the first use.
    """

    def __init__(
        self,
        node: Node,
        robots: Sequence[int],
        nb_robots: int,
        on_content: Callable[[int, Content], None],
    ) -> None:
        """Prepare for robots of a fleet; `on_content` gets the number and content of others."""
        self._node = node
        self._others = [robot for robot in range(1, nb_robots + 1) if robot not in robots]
        self._on_content = on_content
        self._publishers: dict[int, Publisher] = {}
        self._received: list[PolledTopic] = []
        self._ignored: set[str] = set()

    def listen(self) -> None:
        """Subscribe to the messages of the other robots."""
        if not self._received:
            self._received = [self._subscribed(robot) for robot in self._others]

    def take(self) -> None:
        """Take what the others have sent."""
        for topic in self._received:
            topic.take()

    def publish(self, robot: int, content: Content) -> None:
        """Publish what a robot of this process sends."""
        if robot not in self._publishers:
            self._publishers[robot] = self._node.create_publisher(
                Float64MultiArray, topics.robot_topic(robot, topics.MESSAGE), qos.LATCHED_VALUES
            )
        self._publishers[robot].publish(encoded(content))

    def _subscribed(self, robot: int) -> PolledTopic:
        topic = topics.robot_topic(robot, topics.MESSAGE)
        on_message = partial(self._on_message, robot)
        return PolledTopic(self._node, Float64MultiArray, topic, on_message, qos.LATCHED_VALUES)

    def _on_message(self, robot: int, message: Float64MultiArray) -> None:
        try:
            given = message.layout
            content = content_of(given.dim, given.data_offset, message.data)
        except (TypeError, ValueError) as error:
            topic = topics.robot_topic(robot, topics.MESSAGE)
            if topic not in self._ignored:
                self._ignored.add(topic)
                self._node.get_logger().warning(f'ignored a message on {topic}: {error}')
        else:
            self._on_content(robot, content)


def encoded(content: Content) -> Float64MultiArray:
    """Return content as a message."""
    dimensions, numbers = layout(content.value)
    message = Float64MultiArray(data=[content.t, *numbers])
    message.layout.data_offset = 1
    message.layout.dim = [
        MultiArrayDimension(label=one.label, size=one.size, stride=one.stride)
        for one in dimensions
    ]
    return message
