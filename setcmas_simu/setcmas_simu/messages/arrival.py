"""Wait for messages on polled topics."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.subscription import Subscription


def wait_for_any(node: Node, subscriptions: Sequence[Subscription], timeout_s: float) -> list[int]:
    """Return which of some subscriptions have messages, as soon as one has.

    An executor would look at all that its nodes hold.

    Args:
        node: One of the nodes that hold them.
        subscriptions: The subscriptions; they stay as they are.
        timeout_s: Longest time in s.

    Returns:
        Indices; none if the time is over.
    """
    waiting = rclpy_implementation.WaitSet(len(subscriptions), 0, 0, 0, 0, 0, node.context.handle)
    waiting.clear_entities()
    for subscription in subscriptions:
        waiting.add_subscription(subscription.handle)
    waiting.wait(round(timeout_s * 1e9))
    ready = set(waiting.get_ready_entities('subscription'))
    return [i for i, one in enumerate(subscriptions) if one.handle.pointer in ready]
