"""Topics of running robots: read into a live run, and commanded by the buttons of its page."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point32
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, Empty, Float32MultiArray, String, UInt16
from visualization_msgs.msg import Marker, MarkerArray

from setcmas_ctrl.laws.references import References, not_understood
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_topic import FleetListener
from setcmas_simu.ros.messages import seconds_of, state_of
from setcmas_simu.ros.polling import PolledTopic, wait_for_message
from setcmas_tools.page.document import colour_code
from setcmas_tools.page.live_run import LiveRun, RobotDiagnosis, Shape
from setcmas_tools.page.server import Button

_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
_EVENTS = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
_GRAPHS = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Of several controller processes, each of which has the rows of its own robots."""
_MARKERS = QoSProfile(depth=500, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""As many as a trail of a control script keeps for those who come late."""
_KINDS = {DiagnosticStatus.OK: '', DiagnosticStatus.WARN: 'stopped'}
GRACE_S = 3.0
"""Time in s after which contents of vanished topics go; those of a run vanish one by one."""
_FARTHEST_M = 1e6
_LEAST_M = 0.01
_TYPES = {
    'nav_msgs/msg/Odometry': (Odometry, _NEWEST),
    'std_msgs/msg/UInt16': (UInt16, _EVENTS),
    'std_msgs/msg/Float32MultiArray': (Float32MultiArray, _GRAPHS),
    'visualization_msgs/msg/Marker': (Marker, _MARKERS),
    'visualization_msgs/msg/MarkerArray': (MarkerArray, _MARKERS),
}


class LiveTopics:
    """Reads the topics of running robots, new ones as they appear."""

    def __init__(self, node: Node, run: LiveRun) -> None:
        """Subscribe to the topics of the whole fleet; `look` finds the robots."""
        self._node = node
        self._run = run
        self._now = time.monotonic()
        self._topics: dict[str, PolledTopic] = {}
        self._left: dict[str, float] = {}
        self._warned: set[str] = set()
        self._commands: dict[str, PolledTopic] = {}
        self._announced = FleetListener(node)
        self._fleet = [
            PolledTopic(node, Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT),
            PolledTopic(node, Bool, topics.PAUSED, self._on_paused, _NEWEST),
            PolledTopic(node, Bool, topics.EMERGENCY_STOPPED, self._on_stopped, qos.LATCHED),
            PolledTopic(node, Clock, topics.CLOCK, self._on_clock, _NEWEST),
            PolledTopic(node, String, topics.TASK, self._on_task, qos.LATCHED),
            PolledTopic(node, DiagnosticArray, topics.DIAGNOSTICS, self._on_diagnostics, _EVENTS),
        ]

    def look(self) -> None:
        """Follow the changes of the graph since the last look."""
        found = {
            name: _TYPES[types[0]]
            for name, types in self._node.get_topic_names_and_types()
            if types[0] in _TYPES and self._node.count_publishers(name)
        }
        if any(kind is Odometry for kind, _ in found.values()):  # else a run has ended
            self._run.real = any(name.startswith('/mocap/') for name in found)
        wanted = {name: own for name, own in found.items() if self._is_wanted(name, own[0])}
        now = time.monotonic()
        for name in self._topics.keys() - wanted.keys():
            self._topics.pop(name).close()
            self._left[name] = now
        if not any(kind is Odometry for kind, _ in wanted.values()):
            self._run.ended = self._run.ended or bool(self._run.robots)
        elif self._run.ended:  # it stays as it was until another one begins
            self._run.begin()
        if not self._run.ended:
            for name in [name for name, left in self._left.items() if now - left >= GRACE_S]:
                self._forget(name)
        for name in wanted.keys() - self._topics.keys():
            self._forget(name)
            self._topics[name] = self._subscribed(name, *wanted[name])
        self._look_for_commands()

    def _forget(self, topic: str) -> None:
        """Forget what came from publishers of a topic that are gone."""
        self._left.pop(topic, None)
        if topic == topics.COMMUNICATION_GRAPH:
            self._run.connect(np.empty((0, 0)))
        else:
            self._run.erase(topic)

    def wait(self, timeout_s: float) -> None:
        """Wait until a robot publishes its pose: those of a simulation do so together."""
        poses = (
            topic for topic in self._topics.values() if topic.subscription.msg_type is Odometry
        )
        if first := next(poses, None):
            wait_for_message(self._node, first, timeout_s)
        else:
            time.sleep(timeout_s)

    def take(self, now: float) -> None:
        """Take the messages that have come until a time in s."""
        self._now = now
        for topic in (*self._topics.values(), *self._commands.values(), *self._fleet):
            topic.take()
        self._announced.take()
        self._run.models = self._announced.models
        self._run.announced = self._announced.robots

    def _is_wanted(self, name: str, kind: type) -> bool:
        robot = topics.robot_of(name)
        if kind in (Marker, MarkerArray):
            own = robot is not None and name != topics.robot_topic(robot, topics.MARKER)
            return own or name in (topics.OBSTACLES, topics.ARENA)
        if kind is Float32MultiArray:
            return name == topics.COMMUNICATION_GRAPH
        if robot is None:
            return False
        if kind is UInt16:
            return name == topics.robot_topic(robot, topics.TRIG_EVENT)
        # A real TurtleBot3 publishes the odometry of its wheels under the usual name.
        real = self._run.real
        odometry = topics.mocap_topic(robot) if real else topics.robot_topic(robot, topics.ODOM)
        return name == odometry

    def _subscribed(self, name: str, kind: type, profile: QoSProfile) -> PolledTopic:
        robot = topics.robot_of(name) or 0  # obstacles, arena and links are the fleet's
        takes: dict[type, Callable[[Any], None]] = {
            Odometry: partial(self._on_odometry, robot),
            UInt16: partial(self._on_trigger, robot),
            Float32MultiArray: self._on_graph,
        }
        on_message = takes.get(kind, partial(self._on_markers, name))
        return PolledTopic(self._node, kind, name, on_message, profile)

    def _look_for_commands(self) -> None:
        """Subscribe to the commands of one robot; the first command begins the run."""
        subscribed = next(iter(self._commands), None)
        if subscribed and self._node.count_publishers(subscribed):
            return
        robots = self._announced.robots or self._run.robots or [1]
        names = [topics.robot_topic(robot, topics.CMD_CART_VEL) for robot in robots]
        commanded = (name for name in names if self._node.count_publishers(name))
        name = next(commanded, subscribed or names[0])
        if name != subscribed:
            if subscribed:
                self._commands.pop(subscribed).close()
            self._commands[name] = PolledTopic(
                self._node, Point32, name, self._on_command, _NEWEST
            )

    def _on_odometry(self, robot: int, message: Odometry) -> None:
        state = state_of(message)
        if isinstance(state, str):
            self._warn_once(f'robot {robot} is not shown: {state}')
        else:
            self._run.see(robot, state.pose, state.V, self._now)

    def _warn_once(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            self._node.get_logger().warning(text)

    def _on_command(self, _: Point32) -> None:
        self._run.command(self._now)

    def _on_clock(self, message: Clock) -> None:
        self._run.simulated = seconds_of(message.clock)

    def _on_task(self, message: String) -> None:
        try:
            self._run.task = References.decoded(message.data).task
        except ValueError as error:
            self._warn_once(not_understood(error))

    def _on_pause(self, message: Bool) -> None:
        self._run.states.requested = message.data

    def _on_paused(self, message: Bool) -> None:
        self._run.states.announce(message.data, self._now)

    def _on_stopped(self, message: Bool) -> None:
        self._run.states.stopped = message.data

    def _on_trigger(self, robot: int, message: UInt16) -> None:
        if message.data:
            self._run.trigger(robot)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            robot = topics.robot_of(f'/{status.name}/')
            if robot:
                values = {item.key: item.value for item in status.values}
                kind = _KINDS.get(status.level, 'failed')
                reason = status.message if kind else ''
                found = RobotDiagnosis(kind, values.get('state', ''), reason, self._now)
                self._run.states.diagnoses[robot] = found

    def _on_graph(self, message: Float32MultiArray) -> None:
        sizes = [dimension.size for dimension in message.layout.dim]
        if self._run.ended:
            self._run.begin()  # its robots are about to be seen
        if len(sizes) == 2 and sizes[0] == sizes[1] and len(message.data) == sizes[0] * sizes[1]:
            self._run.connect(np.array(message.data, dtype=float).reshape(sizes))

    def _on_markers(self, topic: str, message: Marker | MarkerArray) -> None:
        for marker in message.markers if isinstance(message, MarkerArray) else [message]:
            if shape := planar_shape(marker):
                self._run.draw(topic, f'{marker.ns} {marker.id}', shape)


def planar_shape(marker: Marker) -> Shape | None:
    """Return a disc or a line from above for a marker, which is not turned.

    None for other markers, or without a finite place.
    """
    x, y, size = marker.pose.position.x, marker.pose.position.y, marker.scale.x
    places: list[tuple[float, ...]] = [(x, y)]
    if marker.type == Marker.LINE_STRIP:
        places = [(a.x, a.y, b.x, b.y) for a, b in pairwise(marker.points)]
    elif marker.type not in (Marker.SPHERE, Marker.CYLINDER):
        return None
    colour = marker.color.r, marker.color.g, marker.color.b, marker.color.a
    if not places or not all(map(math.isfinite, (size, *colour, *sum(places, ())))):
        return None
    return {
        'kind': 'lines' if marker.type == Marker.LINE_STRIP else 'discs',
        'places': [
            [round(min(max(part, -_FARTHEST_M), _FARTHEST_M), 4) for part in place]
            for place in places
        ],
        'size': round(min(max(abs(size), _LEAST_M), _FARTHEST_M), 4),
        'colour': colour_code(colour[:3]),
        'alpha': round(min(max(colour[3], 0.0), 1.0), 3),
    }


class FleetCommands:
    """Publishes pause, reset and stop.

    The publishers are made when a page is open: every recorded run would have their topics.
    """

    def __init__(self, node: Node) -> None:
        """Prepare; nothing is published before `prepare`."""
        self._node = node
        self._publishers: dict[Button, Publisher] = {}
        self._subscribers = 0

    def prepare(self) -> None:
        """Make the publishers, so that subscribers know them when a button is pressed."""
        if not self._publishers:
            pause = self._node.create_publisher(Bool, topics.FLEET_PAUSE, qos.EVENT)
            self._publishers = {
                Button.PAUSE: pause,
                Button.START: pause,
                Button.RESET: self._node.create_publisher(Empty, topics.FLEET_RESET, qos.EVENT),
                Button.STOP: self._node.create_publisher(Bool, topics.EMERGENCY_STOP, qos.EVENT),
            }

    def obey(self, button: Button, real: bool) -> None:
        """Do what a button asks for; real robots are paused and stopped only.

        The pause node of an experiment starts robots for its own terminal, whatever is published.
        """
        if real and button in (Button.START, Button.RESET):
            return
        self.prepare()
        is_reset = button is Button.RESET
        self._publishers[button].publish(
            Empty() if is_reset else Bool(data=button is not Button.START)
        )

    def follow_subscribers(self, paused: bool) -> None:
        """Repeat a pause that still holds for controllers that are new since the last call."""
        if not self._publishers:
            return
        subscribers = self._publishers[Button.PAUSE].get_subscription_count()
        if paused and subscribers > self._subscribers:
            self._publishers[Button.PAUSE].publish(Bool(data=True))
        self._subscribers = subscribers
