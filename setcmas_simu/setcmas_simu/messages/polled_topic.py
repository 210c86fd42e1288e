"""Subscription whose messages are polled, without an executor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


class _NeverCalledBack(CallbackGroup):
    """Callback group that an executor skips although it serves the node."""

    def add_entity(self, _: object) -> None:
        pass

    def can_execute(self, _: object) -> bool:
        return False


_POLLED = _NeverCalledBack()


class PolledTopic:
    """Passes the messages of a topic to a function when `take` is called.

    An executor would wake up for each message and rebuild its wait set every time.

    Attributes:
        subscription: The subscription.
    """

    def __init__(
        self,
        node: Node,
        kind: type,
        name: str,
        on_message: Callable[[Any], None],
        profile: QoSProfile,
        encoded: bool = False,
    ) -> None:
        """Subscribe.

        Args:
            node: Holds the subscription.
            kind: Class of the messages.
            name: Full name of the topic.
            on_message: Takes a message.
            profile: Quality of service; its depth bounds the queue.
            encoded: Whether messages are passed on as bytes (see module `cdr`).
        """
        self._node = node
        self._on_message = on_message
        self._depth = profile.depth
        self._encoded = encoded
        self.subscription = node.create_subscription(
            kind, name, on_message, profile, callback_group=_POLLED
        )

    def take(self) -> None:
        """Pass on pending messages."""
        for message in self._messages():
            self._on_message(message)

    def close(self) -> None:
        """Unsubscribe."""
        self._node.destroy_subscription(self.subscription)

    def _messages(self) -> Iterator[Any]:
        handle = self.subscription.handle
        with handle:
            for _ in range(self._depth):
                taken = handle.take_message(self.subscription.msg_type, self._encoded)
                if taken is None:
                    return
                yield taken[0]


def suited_to(node: Node, name: str, depth: int) -> QoSProfile:
    """Return the best quality of service that all publishers of a topic offer."""
    offered = [info.qos_profile for info in node.get_publishers_info_by_topic(name)]
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    latched = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
