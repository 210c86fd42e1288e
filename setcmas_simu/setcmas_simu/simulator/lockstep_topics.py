"""Topics of a simulation in lockstep: answers, states, the forms of messages, and /clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64MultiArray, UInt8MultiArray

from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.messages import LocatedMessage, decode_forms, encode_forms
from setcmas_simu.ros.polling import OnDemandPublisher, PolledTopic
from setcmas_simu.simulator.lockstep import (
    Answer,
    Commands,
    States,
    decode,
    decode_states,
    encode,
    encode_states,
    this_process,
)

_WARN_EVERY_S = 10.0
_Content = TypeVar('_Content')


class Answerer:
    """Answers for this process."""

    def __init__(self, node: Node, robots: tuple[int, ...] = ()) -> None:
        """Prepare to answer for controllers of these robots; without robots, for a recorder."""
        self._follower = this_process(robots)
        # Recorders get the first answers, too.
        profile = qos.LOCKSTEP_STATE if robots else qos.LATCHED
        self._publisher = node.create_publisher(Float64MultiArray, topics.LOCKSTEP, profile)

    def answer(
        self, stamp: int, commands: tuple[Commands, ...] = (), leaves: bool = False
    ) -> None:
        """Report that this process has finished with the states of a time, in ns.

        Args:
            stamp: The time.
            commands: Commands of its robots since the last answer.
            leaves: Whether this process stops following.
        """
        answer = Answer(self._follower, stamp, leaves, commands)
        self._publisher.publish(Float64MultiArray(data=encode(answer)))


class _CheckedTopic(PolledTopic):
    """Passes what is in an array to a function; reports and ignores invalid arrays."""

    def __init__(
        self,
        node: Node,
        kind: type,
        name: str,
        profile: QoSProfile,
        decoded: Callable[[Any], _Content],
        on_content: Callable[[_Content], None],
    ) -> None:
        warn = node.get_logger().warning

        def on_array(message: Any) -> None:
            try:
                content = decoded(message.data)
            except ValueError as error:
                warn(f'ignored a message on {name}: {error}', throttle_duration_sec=_WARN_EVERY_S)
            else:
                on_content(content)

        super().__init__(node, kind, name, on_array, profile)


class AnswerTopic(_CheckedTopic):
    """Passes answers to a function."""

    def __init__(
        self,
        node: Node,
        on_answer: Callable[[Answer], None],
        profile: QoSProfile = qos.LATCHED_BY_MANY,
    ) -> None:
        super().__init__(node, Float64MultiArray, topics.LOCKSTEP, profile, decode, on_answer)


class StatesPublisher:
    """Publishes the states of each step, and once the forms of the messages with them."""

    def __init__(self, node: Node, forms: dict[str, LocatedMessage]) -> None:
        """Publish the forms, by full names of topics."""
        self._forms = node.create_publisher(UInt8MultiArray, topics.LOCKSTEP_FORMS, qos.LATCHED)
        self._forms.publish(UInt8MultiArray(data=encode_forms(forms)))
        self._states = node.create_publisher(
            Float64MultiArray, topics.LOCKSTEP_STATES, qos.LOCKSTEP_STATE
        )

    def publish(self, states: States) -> None:
        """Publish the states of a step."""
        self._states.publish(Float64MultiArray(data=encode_states(states)))


class StatesTopic(_CheckedTopic):
    """Passes states to a function, as soon as the forms of the messages with them are known.

    Attributes:
        forms: Messages with a robot's state, by full names of topics.
    """

    def __init__(
        self,
        node: Node,
        on_states: Callable[[States], None],
        profile: QoSProfile = qos.LATCHED,
    ) -> None:
        self.forms: dict[str, LocatedMessage] = {}
        self._forms_topic = _CheckedTopic(
            node,
            UInt8MultiArray,
            topics.LOCKSTEP_FORMS,
            qos.LATCHED,
            decode_forms,
            self._on_forms,
        )
        super().__init__(
            node, Float64MultiArray, topics.LOCKSTEP_STATES, profile, decode_states, on_states
        )

    def take(self) -> None:
        """Pass on pending states."""
        self._forms_topic.take()
        if self.forms:
            super().take()

    def _on_forms(self, forms: dict[str, LocatedMessage]) -> None:
        self.forms |= {name: form for name, form in forms.items() if topics.is_in_steps(name)}


class ClockTopic:
    """Publishes the time of a simulation."""

    def __init__(self, node: Node, in_lockstep: bool) -> None:
        """Create the topic; in lockstep it is published on demand."""
        publisher = node.create_publisher(Clock, topics.CLOCK, qos.LOCKSTEP_STATE)
        self._publisher = OnDemandPublisher(publisher, not in_lockstep)

    def publish(self, stamp: Time) -> None:
        """Publish a time."""
        self._publisher.publish(lambda: Clock(clock=stamp))
