"""Wait for messages on polled topics."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription


def wait_for_any(node: Node, subscriptions: Sequence[Subscription], timeout_s: float) -> list[int]:
    """Wait until a subscription has a message; return the indices of all that have one.

    An executor would check every entity of its nodes instead.

    Args:
        node: A node that holds one of them.
        subscriptions: The subscriptions; their messages are not taken.
        timeout_s: Longest wait in s.

    Returns:
        Indices; none after a time-out.
    """
    waiting = rclpy_implementation.WaitSet(len(subscriptions), 0, 0, 0, 0, 0, node.context.handle)
    waiting.clear_entities()
    for subscription in subscriptions:
        waiting.add_subscription(subscription.handle)
    waiting.wait(round(timeout_s * 1e9))
    ready = set(waiting.get_ready_entities('subscription'))
    return [i for i, one in enumerate(subscriptions) if one.handle.pointer in ready]
