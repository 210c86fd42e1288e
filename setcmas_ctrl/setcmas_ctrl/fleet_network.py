"""Links of a process of controllers: which states its robots receive, over topics and channels."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial

import numpy as np
from builtin_interfaces.msg import Time
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Float32MultiArray, Float64MultiArray, MultiArrayDimension, String

from setcmas_ctrl.communication.communication_options import Communication
from setcmas_ctrl.communication.delay_and_loss import Links
from setcmas_ctrl.communication.message_content import Content, Value, decoded, encoded
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import RobotState, state_of, wait_until_received
from setcmas_simu.ros.polling import PolledTopic

_COUNTS_EVERY_S = 1.0
_GRAPH_EVERY_S = 0.2
_TIMER_JITTER_S = 0.02


class FleetNetwork:
    """What each robot of a process knows of the others: their poses, and messages of their laws.

    Attributes:
        is_on: Whether there are links. Robots that know all poses have none until a law uses
            messages.
        t: Time of the current calls in s.
    """

    def __init__(
        self,
        node: Node,
        poses: FleetPoses,
        communication: Communication,
        robots: list[int],
    ) -> None:
        """Subscribe to the states that the fleet sends to some robots, those of this process.

        Without event triggering the poses must be those of all robots.
        """
        self._node = node
        self._poses = poses
        self._communication = communication
        self._robots = robots
        self._own = np.array(robots) - 1
        self._nb_robots = poses.poses.shape[1]
        self._published: Floats = np.zeros((self._nb_robots, self._nb_robots))
        self._segment = ''
        self._log = node.get_logger().info
        self._begun = False
        self._next_graph = self._next_counts = 0.0
        self._graph_publisher: Publisher | None = None
        self._counts_publishers: list[Publisher] = []
        self._states: list[PolledTopic] = []
        self._stamps: dict[int, Time] = {}
        self._message_publishers: dict[int, Publisher] = {}  # none before the first use
        self._messages: list[PolledTopic] = []
        self._ignored: set[int] = set()
        self.t = 0.0
        self.is_on = not communication.is_ideal
        self._known: Floats = poses.poses[None]
        self._adjacency: Floats | None = None
        if self.is_on:
            self._open()

    def _open(self) -> None:
        """Create the topics."""
        if not self._communication.reaches_all:
            self._graph_publisher = self._node.create_publisher(
                Float32MultiArray, topics.COMMUNICATION_GRAPH, qos.LATCHED
            )
        self._counts_publishers = [
            self._node.create_publisher(
                Float64MultiArray, topics.robot_topic(robot, topics.LINKS), qos.LATCHED
            )
            for robot in self._robots
        ]
        if self._communication.event_triggered:
            self._states = [
                PolledTopic(
                    self._node,
                    Odometry,
                    topics.robot_topic(robot, topics.TRIG_ODOM),
                    partial(self._on_state, robot),
                    qos.LATCHED,
                )
                for robot in range(1, self._nb_robots + 1)
            ]

    @cached_property
    def _links(self) -> Links:
        return self._communication.links(self._robots)

    def begin(self) -> None:
        """Prepare for messages, on links over which the robots have sent their poses already."""
        if not self._messages:
            self._messages = [
                PolledTopic(
                    self._node,
                    String,
                    topics.robot_topic(robot, topics.MESSAGE),
                    partial(self._on_message, robot),
                    qos.LATCHED_VALUES,
                )
                for robot in range(1, self._nb_robots + 1)
                if robot not in self._robots
            ]
        if not self.is_on:
            self.is_on = True
            self._open()
            self._links.send(np.arange(self._nb_robots), self._poses.poses, self._poses.now)
            self.begin_step(self.t)

    def send(self, robot: int, value: Value) -> None:
        """Let the next states that a robot of this process sends carry a value."""
        content = Content(self.t, value)
        self._attach(robot, content)
        if robot not in self._message_publishers:
            self._message_publishers[robot] = self._node.create_publisher(
                String, topics.robot_topic(robot, topics.MESSAGE), qos.LATCHED_VALUES
            )
        self._message_publishers[robot].publish(String(data=encoded(content)))

    def received(self, robot: int) -> Mapping[int, Content]:
        """Return what a robot of this process has received last, by the senders' numbers."""
        contents = self._links.contents(self._robots.index(robot))
        return {sender + 1: content for sender, content in contents.items()}

    def forget_messages(self) -> None:
        """Drop all messages: the laws start anew."""
        if self.is_on:
            self._links.forget_contents()

    def _attach(self, robot: int, content: Content) -> None:
        self._links.attach(robot - 1, content)

    def _on_message(self, robot: int, message: String) -> None:
        try:
            self._attach(robot, decoded(message.data))
        except (TypeError, ValueError) as error:
            if robot not in self._ignored:
                self._ignored.add(robot)
                topic = topics.robot_topic(robot, topics.MESSAGE)
                self._node.get_logger().warning(f'ignored a message on {topic}: {error}')

    def take_values(self) -> None:
        """Take values from other processes; call before taking the states that carry them."""
        for topic in self._messages:
            topic.take()

    def take(self) -> None:
        """Take the states that robots have sent, which are their poses unless they send by events.

        Call it after taking poses.
        """
        for topic in self._states:
            topic.take()
        if self.is_on and not self._communication.event_triggered:
            for robot, state in self._poses.new.items():
                self._send(robot, state)

    def _on_state(self, robot: int, message: Odometry) -> None:
        state = state_of(message)
        if isinstance(state, RobotState):
            stamp = message.header.stamp
            # The last state is repeated in case that it was lost; that sends nothing new.
            known = self._stamps.get(robot), tuple(self._links.last_sent[:, robot - 1])
            if (stamp, state.pose) != known:
                self._stamps[robot] = stamp
                self._send(robot, state)

    def _send(self, robot: int, state: RobotState) -> None:
        self._links.send([robot - 1], np.array(state.pose)[:, None], self._poses.now)

    def missing(self) -> list[int]:
        """Return the robots that have not sent a state yet."""
        if not self.is_on:
            return []
        return [int(i) + 1 for i in np.flatnonzero(np.isnan(self._links.last_sent[0]))]

    def begin_step(self, t: float) -> None:
        """Bring the links up to date at time t (s), before the laws are called."""
        self.t, poses = t, self._poses.poses
        if not self.is_on:
            self._known = poses[None]
            return
        now = self._poses.now
        # A step at t = 9.9998 s corresponds to t = 10 s offline, when a graph may switch.
        t += _TIMER_JITTER_S
        self._report_segment(t)
        adjacency = self._communication.graph.adjacency(t, poses[:2])
        if not self._begun:
            self._begun = True
            self._links.begin(adjacency)
        else:
            self._links.connect(adjacency, now)
        if now >= self._next_graph and not np.array_equal(adjacency, self._published):
            self._next_graph = now + _GRAPH_EVERY_S - 0.01
            self._published = adjacency
            self._publish_graph(adjacency)
        if now >= self._next_counts:
            self._next_counts = now + _COUNTS_EVERY_S
            self._publish_counts()
        self._known = self._links.known_poses(poses[:, self._own], now)
        self._adjacency = adjacency

    def known_by(self, robot: int) -> tuple[Floats, Floats | None]:
        """Return the poses that a robot of this process knows, and the adjacency matrix.

        Returns:
            Poses (3, N), NaN for unknown robots; and the matrix (N, N), None if it is complete.
        """
        if not self.is_on:
            return self._known[0], None
        return self._known[self._robots.index(robot)], self._adjacency

    def _report_segment(self, t: float) -> None:
        segment = self._communication.graph.segment(t).name
        if segment != self._segment and self._graph_publisher:
            self._segment = segment
            self._log(f'graph at t = {t:.1f} s: {segment}')

    def stop(self) -> None:
        """Publish the final counts, and wait briefly until they have arrived."""
        if not self.is_on:
            return
        self._publish_counts()
        wait_until_received(self._counts_publishers)

    def _publish_graph(self, adjacency: Floats) -> None:
        if self._graph_publisher:
            # Another process publishes the rows of its own robots, at its own time t.
            weights = np.full_like(adjacency, np.nan)
            weights[self._own] = adjacency[self._own]
            message = Float32MultiArray(data=weights.ravel().tolist())
            message.layout.dim = _dimensions(weights, 'receiver', 'sender')
            self._graph_publisher.publish(message)

    def _publish_counts(self) -> None:
        counts = self._links.counts
        columns = np.stack(
            [counts.sent, counts.received, counts.lost, counts.mean_interval], axis=-1
        )
        for publisher, table in zip(self._counts_publishers, columns, strict=True):
            message = Float64MultiArray(data=table.ravel().tolist())
            message.layout.dim = _dimensions(table, 'sender', 'sent received lost mean_interval')
            publisher.publish(message)


def _dimensions(matrix: Floats, *labels: str) -> list[MultiArrayDimension]:
    rows, columns = matrix.shape
    return [
        MultiArrayDimension(label=labels[0], size=rows, stride=rows * columns),
        MultiArrayDimension(label=labels[1], size=columns, stride=columns),
    ]
