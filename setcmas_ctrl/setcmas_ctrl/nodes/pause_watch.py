"""Listens to the pause state of an experiment; silence means pause."""

from __future__ import annotations

import time

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_simu import topics
from setcmas_simu.nodes import qos

PAUSE_TIMEOUT_S = 0.5
"""Age in s from which the last word of the pause node is too old."""

BY_WISH = 'paused'
SILENT = 'paused: nothing is heard of the pause node'
SEVERAL = 'paused: several pause nodes send /paused; is another experiment in this ROS domain?'


class PauseWatch:
    """The pause state that a process acts upon: paused unless told otherwise, all the time."""

    def __init__(self, node: Node, timeout_s: float = PAUSE_TIMEOUT_S) -> None:
        """Listen through a node."""
        self._node = node
        self._timeout_s = timeout_s
        self._paused = True
        self._received = -float('inf')
        self._several = False
        node.create_subscription(
            Bool,
            topics.PAUSED,
            self._on_paused,
            qos.STATE,
            event_callbacks=qos.no_subscription_events(),
        )

    def reason(self) -> str:
        """Return why robots are paused; empty if they are not."""
        if self._several:
            return SEVERAL
        if time.monotonic() - self._received > self._timeout_s:
            return SILENT
        return BY_WISH if self._paused else ''

    def check_graph(self) -> None:
        """See that no second pause node contradicts the first; to be called now and then."""
        self._several = self._node.count_publishers(topics.PAUSED) > 1

    def _on_paused(self, message: Bool) -> None:
        self._paused = message.data
        self._received = time.monotonic()
