"""Who sends the poses of a robot, as the ROS graph tells."""

from __future__ import annotations

from rclpy.node import Node


def source_conflict(node: Node, source: str) -> str:
    """Return why no pose on a topic is to be believed; empty if they may be.

    A second sender may be an emulated lab or a bag that is played: its poses are as plausible.
    """
    senders = node.count_publishers(source)
    return f'{senders} nodes send it on {source}' if senders > 1 else ''
