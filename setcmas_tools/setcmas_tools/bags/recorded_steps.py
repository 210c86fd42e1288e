"""Messages of robots in lockstep, made from the arrays of each step for a bag."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from builtin_interfaces.msg import Time
from geometry_msgs.msg import TwistStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import NO_STAMP, LocatedMessage, encode_point
from setcmas_simu.ros.polling import PolledTopic
from setcmas_simu.simulator.lockstep import Answer, Commands, States
from setcmas_simu.simulator.lockstep_topics import Answerer, AnswerTopic, StatesTopic
from setcmas_tools.bags.recorded_topic import DEPTH


class StepMessage(NamedTuple):
    """An encoded message, and when its array arrived and was sent, in ns."""

    time_ns: int
    sent_ns: int
    data: bytes


OnMessage = Callable[[str, str, StepMessage], None]
"""Takes the full name of a topic, its type, and a message."""

_ALL = QoSProfile(depth=DEPTH, durability=qos.LATCHED.durability)


class RecordedSteps:
    """Makes the messages of each step, and answers the simulator, which waits for recorders."""

    def __init__(self, node: Node, on_message: OnMessage) -> None:
        """Subscribe to the arrays; pass messages on to a function."""
        self._on_message = on_message
        self._answerer = Answerer(node)
        self._stamp = NO_STAMP
        self._states = StatesTopic(node, self._on_states, _ALL)
        self._answers = AnswerTopic(node, self._on_answer, _ALL)

    def take(self) -> None:
        """Make the messages of new steps, and report the newest one."""
        before = self._stamp
        self._states.take()
        self._answers.take()
        if self._stamp != before:
            self._answerer.answer(self._stamp)

    def leave(self) -> None:
        """Let the simulator go on without this recorder."""
        self._answerer.answer(self._stamp, leaves=True)

    def _on_states(self, states: States) -> None:
        self._stamp = states.stamp
        seconds, nanoseconds = divmod(states.stamp, 10**9)
        clock = serialize_message(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        self._pass(self._states, topics.CLOCK, 'rosgraph_msgs/msg/Clock', clock)
        rows = {int(row[0]): row[1:] for row in states.table.tolist()}
        for name, form in self._states.forms.items():
            robot = topics.robot_of(name)
            if robot in rows:
                self._pass_of(self._states, name, form.at(states.stamp, rows[robot]))

    def _on_answer(self, answer: Answer) -> None:
        for commands in answer.commands:
            for name, data in _messages(answer.follower.robots, commands):
                self._pass_of(self._answers, name, data)

    def _pass_of(self, array: PolledTopic, name: str, data: bytes) -> None:
        self._pass(array, name, topics.IN_STEPS[name.rpartition('/')[-1]], data)

    def _pass(self, array: PolledTopic, name: str, msgtype: str, data: bytes) -> None:
        self._on_message(name, msgtype, StepMessage(array.received_ns, array.sent_ns, data))


def _messages(robots: tuple[int, ...], commands: Commands) -> Iterator[tuple[str, bytes]]:
    """Yield the messages of commands, in the order in which controllers send them."""
    rows = list(zip(robots, commands.rows, strict=True))
    for robot, row in rows:
        yield from _point(robot, topics.CMD_CART_VEL, (*row[3:5], 0.0))
    for robot, row in rows:
        yield from _point(robot, topics.CMD_CART_VEL_ALLOWED, row[5:8])
    for robot, (V, left, omega, *_) in rows:
        if not math.isnan(V):
            state = (0.0, 0.0, 0.0, 0.0, V, left, omega)
            data = _command(robot).at(commands.stamp, state)
            yield topics.robot_topic(robot, topics.CMD_VEL), data


def _point(robot: int, topic: str, xyz: tuple[float, ...]) -> Iterator[tuple[str, bytes]]:
    if not math.isnan(xyz[0]):
        yield topics.robot_topic(robot, topic), encode_point(*xyz)


@functools.cache
def _command(robot: int) -> LocatedMessage:
    message = TwistStamped()
    message.header.frame_id = topics.robot_frame(robot)
    return LocatedMessage.of(message, twist='twist')
