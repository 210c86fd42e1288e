"""Topics of the browser view, new ones as they appear on the graph."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Point32
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, Float32MultiArray, UInt16
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_ctrl.communication.graph import with_known_rows
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet import topics
from setcmas_simu.fleet.planar_pose import yaw_of_quaternion
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.polling import PolledTopic, suited_to
from setcmas_tools.view.model import communication
from setcmas_tools.view.model.departures import Departures
from setcmas_tools.view.model.fleet_state import NO_PAIRS, FleetState
from setcmas_tools.view.model.robot_states import Diagnosis

_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_EVENTS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
_GRAPHS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Of several controller processes, each of which tells what its own robots hear."""
_MARKER_DEPTH = 500  # as many as a trail of a control script keeps for those who come late
_KINDS = {
    'nav_msgs/msg/Odometry': Odometry,
    'std_msgs/msg/UInt16': UInt16,
    'visualization_msgs/msg/Marker': Marker,
    'visualization_msgs/msg/MarkerArray': MarkerArray,
}


class ViewedTopics:
    """Keeps what is known of a fleet up to date."""

    def __init__(self, node: Node, state: FleetState) -> None:
        """Listen to what concerns the whole fleet; `look` finds the robots."""
        self._node = node
        self._state = state
        self._now = time.monotonic()
        self._robots: dict[str, PolledTopic] = {}
        self._commands: dict[str, PolledTopic] = {}
        self._adjacency: Floats = np.empty((0, 0))
        self._departures = Departures()
        self._announced = FleetListener(node)
        diagnosed = partial(PolledTopic, node, DiagnosticArray, topics.DIAGNOSTICS)
        self._fleet = [
            PolledTopic(node, Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT),
            PolledTopic(node, Bool, topics.PAUSED, self._on_paused, _NEWEST),
            PolledTopic(node, Bool, topics.EMERGENCY_STOPPED, self._on_stopped, qos.LATCHED),
            PolledTopic(node, Clock, topics.CLOCK, self._on_clock, _NEWEST),
            diagnosed(self._on_diagnostics, _EVENTS),
            PolledTopic(
                node,
                Float32MultiArray,
                topics.COMMUNICATION_GRAPH,
                self._on_graph,
                _GRAPHS,
            ),
        ]

    def look(self) -> None:
        """Follow the changes of the graph since the last look."""
        found = {
            name: _KINDS[types[0]]
            for name, types in self._node.get_topic_names_and_types()
            if types[0] in _KINDS and self._node.count_publishers(name)
        }
        mocap = [name for name in found if name.startswith('/mocap/')]
        if Odometry in found.values():  # else a run has ended, and stays what it was
            self._state.real = bool(mocap)
        wanted = {name: kind for name, kind in found.items() if self._is_wanted(name, kind)}
        for name in self._robots.keys() - wanted.keys():
            self._robots.pop(name).close()
        self._follow_runs(Odometry in wanted.values())
        if not self._state.ended:
            self._drop_what_is_gone(set(wanted))
        for name in wanted.keys() - self._robots.keys():
            self._robots[name] = self._subscribed(name, wanted[name])
        self._look_for_commands()

    def _follow_runs(self, robots_there: bool) -> None:
        """See that a run that has ended stays as it was until another one begins."""
        if robots_there and self._state.ended:
            self._state.begin()
        elif not robots_there and self._state.fleet.robots:
            self._state.ended = True

    def _drop_what_is_gone(self, there: set[str]) -> None:
        """Forget what was drawn, and the communication graph, when who told it is gone."""
        if self._node.count_publishers(topics.COMMUNICATION_GRAPH):
            there = there | {topics.COMMUNICATION_GRAPH}
        gone = self._departures.look(there, time.monotonic())
        self._state.markers.drop_topics(gone)
        if topics.COMMUNICATION_GRAPH in gone - there:
            self._adjacency = np.empty((0, 0))
            self._state.both, self._state.one_way = NO_PAIRS, NO_PAIRS

    def take(self, now: float) -> None:
        """Take what has come until a time in s."""
        self._now = now
        for topic in (*self._robots.values(), *self._commands.values(), *self._fleet):
            topic.take()
        self._announced.take()
        self._state.models = self._announced.models
        self._state.announced = self._announced.robots

    def _is_wanted(self, name: str, kind: type) -> bool:
        robot = topics.robot_of(name)
        if kind in (Marker, MarkerArray):
            return robot is None or name != topics.robot_topic(robot, topics.MARKER)
        if robot is None:
            return False
        if kind is UInt16:
            return name == topics.robot_topic(robot, topics.TRIG_EVENT)
        # A real TurtleBot3 publishes the odometry of its wheels under the usual name.
        real = self._state.real
        return name == (
            topics.mocap_topic(robot) if real else topics.robot_topic(robot, topics.ODOM)
        )

    def _subscribed(self, name: str, kind: type) -> PolledTopic:
        robot = topics.robot_of(name) or 0  # markers may be the fleet's
        if kind is Odometry:
            return PolledTopic(self._node, kind, name, partial(self._on_odometry, robot), _NEWEST)
        if kind is UInt16:
            on_event = partial(self._on_trigger, robot)
            return PolledTopic(self._node, kind, name, on_event, _EVENTS)
        on_markers = partial(self._on_marker if kind is Marker else self._on_markers, name)
        profile = suited_to(self._node, name, _MARKER_DEPTH)
        return PolledTopic(self._node, kind, name, on_markers, profile)

    def _look_for_commands(self) -> None:
        """Listen to the commands of one robot, whose first one begins the run.

        Before there are any: that is what the first one is heard by.
        """
        heard = next(iter(self._commands), None)
        if heard and self._node.count_publishers(heard):
            return
        robots = self._announced.robots or self._state.fleet.robots or [1]
        names = [topics.robot_topic(robot, topics.CMD_CART_VEL) for robot in robots]
        commanded = (name for name in names if self._node.count_publishers(name))
        name = next(commanded, heard or names[0])
        if name != heard:
            if heard:
                self._commands.pop(heard).close()
            self._commands[name] = PolledTopic(
                self._node, Point32, name, self._on_command, _NEWEST
            )

    def _on_odometry(self, robot: int, message: Odometry) -> None:
        position, q = message.pose.pose.position, message.pose.pose.orientation
        pose = (position.x, position.y, yaw_of_quaternion(q.x, q.y, q.z, q.w))
        self._state.fleet.see(robot, pose, message.twist.twist.linear.x, self._now)

    def _on_command(self, _: Point32) -> None:
        # The time of the control laws stands still while they are paused.
        self._state.clock.heard(self._now, self._state.states.paused(self._now))

    def _on_clock(self, message: Clock) -> None:
        self._state.clock.follow(message.clock.sec + 1e-9 * message.clock.nanosec)

    def _on_pause(self, message: Bool) -> None:
        self._state.states.wish(message.data)

    def _on_paused(self, message: Bool) -> None:
        self._state.states.announce(message.data, self._now)

    def _on_stopped(self, message: Bool) -> None:
        self._state.states.stopped = message.data

    def _on_trigger(self, robot: int, message: UInt16) -> None:
        if message.data:
            self._state.flashes.trigger(robot, self._now)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            robot = topics.robot_of(f'/{status.name}/')
            if robot:
                values = {item.key: item.value for item in status.values}
                level = int.from_bytes(status.level, 'little')
                reason = status.message if level else ''
                self._state.states.diagnose(
                    robot, Diagnosis(level, values.get('state', ''), reason, self._now)
                )

    def _on_graph(self, message: Float32MultiArray) -> None:
        sizes = [dimension.size for dimension in message.layout.dim]
        if self._state.ended:
            self._state.begin()  # its robots are about to be seen
        weights = communication.matrix(sizes, message.data.tolist())
        if weights is None:
            return
        if weights.shape == self._adjacency.shape:
            weights = with_known_rows(weights, self._adjacency)
        self._adjacency = weights
        self._state.both, self._state.one_way = communication.links(weights)

    def _on_marker(self, topic: str, marker: Marker) -> None:
        self._state.markers.apply(topic, marker, self._now)

    def _on_markers(self, topic: str, message: Any) -> None:
        for marker in message.markers:
            self._on_marker(topic, marker)
