"""Listens for emergency stops, and for the operator who releases them."""

from __future__ import annotations

import time

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_ctrl.fleet.pause_watch import SURE_AFTER_S
from setcmas_simu.fleet import topics
from setcmas_simu.messages.polled_topic import PolledTopic
from setcmas_simu.ros import qos

STOPPED = 'emergency stop'


class EmergencyWatch:
    """Holds an emergency stop until the pause node that has taken it over lets go.

    Anybody may stop. Only a pause node that said "stopped" since, and is the only one in sight,
    ends it by saying "not stopped": one that comes later, or somebody else's, does not.

    Attributes:
        stopped: Whether robots must stand, by what has come.
    """

    def __init__(self, node: Node) -> None:
        """Listen through a node."""
        self._node = node
        self.stopped = False
        self._holder: bytes | None = None
        self._free_since: float | None = None
        stop, state = topics.EMERGENCY_STOP, topics.EMERGENCY_STOPPED
        # Who publishes without latching matches only the one, who latched it earlier the other.
        self._topics = [
            PolledTopic(node, Bool, stop, self._on_stop, qos.EVENT),
            PolledTopic(node, Bool, stop, self._on_stop, qos.LATCHED),
            PolledTopic(node, Bool, state, self._on_state, qos.LATCHED_BY_MANY),
        ]

    def take(self) -> bool:
        """Take what has come; returns whether robots must stand."""
        for topic in self._topics:
            topic.take()
        return self.stopped

    def _on_stop(self, message: Bool) -> None:
        if message.data and not self.stopped:
            self.stopped, self._holder, self._free_since = True, None, None

    def _on_state(self, message: Bool) -> None:
        source = self._only_source()
        if message.data:
            self.stopped, self._holder, self._free_since = True, source, None
        elif self._holder is not None and self._holder == source:
            # Who sent a message cannot be known: the holder repeats its own in between.
            now = time.monotonic()
            self._free_since = self._free_since or now
            if now - self._free_since >= SURE_AFTER_S:
                self.stopped, self._holder = False, None

    def _only_source(self) -> bytes | None:
        found = self._node.get_publishers_info_by_topic(topics.EMERGENCY_STOPPED)
        return bytes(found[0].endpoint_gid) if len(found) == 1 else None
