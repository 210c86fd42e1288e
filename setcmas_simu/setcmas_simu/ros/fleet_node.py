"""Node whose namespace is the root of all topic names, so that fleets can live side by side."""

from __future__ import annotations

import re
import weakref
from collections.abc import Callable, Sequence
from functools import cached_property
from types import SimpleNamespace
from typing import Any, cast

import rclpy
from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent, ParameterType
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import POLLED, UNREADABLE

SIMULATED_TIME = 'use_sim_time'
"""Parameter of every ROS node: follow /clock."""


class FleetNode(Node):
    """A node that takes its namespace as the root of all topic names.

    So `-r __ns:=/a` moves a whole fleet to /a, and other fleets do not see it there.
    """

    def __init__(self, node_name: str, follows_clock: bool = False, **kwargs: Any) -> None:
        """Create the node; other arguments as for `rclpy.node.Node`, but without /rosout.

        Raises:
            SetcmasError: The user has set use_sim_time, and the node does not follow /clock.
        """
        overrides = [
            Parameter('start_type_description_service', Parameter.Type.BOOL, False),
            *kwargs.pop('parameter_overrides', []),
        ]
        self._is_quiet = not kwargs.setdefault('enable_rosout', False)
        super().__init__(node_name, parameter_overrides=overrides, **kwargs)
        _nodes.add(self)
        if self.get_parameter(SIMULATED_TIME).value and not follows_clock:
            raise SetcmasError(
                f'{self.get_name()} refuses {SIMULATED_TIME}: only controllers of robots of '
                'another simulator need it; setcmas simu has --rtf'
            )
        text = 'whether time follows /clock' if follows_clock else 'always false'
        kind = ParameterType.PARAMETER_BOOL
        fixed = ParameterDescriptor(type=kind, description=text, read_only=True)
        self.set_descriptor(SIMULATED_TIME, fixed)

    @cached_property
    def fleet_namespace(self) -> str:
        """Namespace of the fleet; '' for the root."""
        return self.get_namespace().rstrip('/')

    def fixed(self, name: str, value: Any, text: str, is_given: bool = True) -> Any:
        """Declare a parameter that can only be set at the start; return its value.

        That is the one in `--ros-args`, if it may be given there, or else the given value. A real
        number may be given as a whole one.
        """
        described = ParameterDescriptor(
            type=Parameter.Type.from_parameter_value(value).value,
            description=text,
            read_only=True,
            dynamic_typing=True,  # to ROS `-p x0:=2` is an integer
        )
        given = self.declare_parameter(name, value, described, ignore_override=not is_given).value
        return float(given) if type(given) is int and isinstance(value, float) else given

    def full_name(self, topic: str) -> str:
        """Return a topic's name in the graph; /rosout and /parameter_events have no namespace."""
        stays = topic[:1] != '/' or topic.startswith(f'{self.fleet_namespace}/')
        return topic if stays or topic in topics.OF_ROS else f'{self.fleet_namespace}{topic}'

    def name_in_fleet(self, topic: str) -> str:
        """Return a topic's name without the namespace of the fleet."""
        return f'/{topic.removeprefix(f"{self.fleet_namespace}/").lstrip("/")}'

    def create_publisher(self, msg_type: Any, topic: str, *args: Any, **kwargs: Any) -> Publisher:
        """Create a publisher without event callbacks, which would burden the executor."""
        if msg_type is ParameterEvent and self._is_quiet:
            return cast(Publisher, SimpleNamespace(publish=bool))  # discards them
        kwargs.setdefault('event_callbacks', PublisherEventCallbacks(use_default_callbacks=False))
        return super().create_publisher(msg_type, self.full_name(topic), *args, **kwargs)

    def create_subscription(
        self, msg_type: Any, topic: str, *args: Any, **kwargs: Any
    ) -> Subscription:
        """Create a subscription without event callbacks, which would burden the executor."""
        silent = SubscriptionEventCallbacks(use_default_callbacks=False)
        kwargs.setdefault('event_callbacks', silent)
        return super().create_subscription(msg_type, self.full_name(topic), *args, **kwargs)

    def newest(
        self, kind: type, topic: str, profile: QoSProfile = qos.STATE, raw: bool = False
    ) -> Callable[[], Any]:
        """Subscribe; return a function that returns the newest message since its last call.

        It returns None if none has come, or one that its sender has cut short. A raw message stays
        serialised, and may be cut short.
        """
        latest = QoSProfile(
            depth=1, reliability=profile.reliability, durability=profile.durability
        )
        handle = self.create_subscription(
            kind, topic, _ignore, latest, callback_group=POLLED
        ).handle

        def take() -> Any:
            try:
                taken = handle.take_message(kind, raw)
            except UNREADABLE:
                return None
            return taken and taken[0]

        return take

    def count_publishers(self, topic_name: str) -> int:
        """Return the number of publishers of a topic."""
        return super().count_publishers(self.full_name(topic_name))

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return the publishers of a topic."""
        return super().get_publishers_info_by_topic(self.full_name(topic_name), no_mangle)

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return the subscriptions to a topic."""
        return super().get_subscriptions_info_by_topic(self.full_name(topic_name), no_mangle)

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        """Return the topics of this fleet, without those of fleets in namespaces within."""
        found = super().get_topic_names_and_types(no_demangle)
        return topics.of_fleet(found, self.fleet_namespace)


def _ignore(_: Any) -> None:
    """Stand in for the callback that every subscription must have."""


_nodes: weakref.WeakSet[FleetNode] = weakref.WeakSet()
_arguments: list[str] = []  # for ROS, of this process


def note_arguments(ros_arguments: Sequence[str]) -> None:
    """Note the ROS arguments of this process, for `of_other_nodes`."""
    _arguments[:] = ros_arguments


def destroy_nodes() -> None:
    """Destroy the nodes of the default context, which would stay in the graph for seconds."""
    for node in list(_nodes):
        if node.context is rclpy.get_default_context():
            node.destroy_node()


def of_other_nodes() -> dict[str, Any]:
    """Return the ROS arguments of this process for its further nodes, as arguments of `Node`.

    Rules such as `__ns:=/lab` are left out: ROS would apply them to all nodes, not only the first.
    """
    kept: list[str] = []
    for word in _arguments:
        if _NAMES.match(word):
            kept.pop()  # -r
        else:
            kept.append(word)
    if kept == _arguments:
        return {}
    return {'use_global_arguments': False, 'cli_args': kept}


_NAMES = re.compile(r'(__ns|__node|__name):=')
