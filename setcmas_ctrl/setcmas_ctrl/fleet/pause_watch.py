"""Listens to the pause state of an experiment; silence means pause."""

from __future__ import annotations

import time

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_ctrl.control.options import PAUSE_TIMEOUT_S
from setcmas_simu.fleet import topics
from setcmas_simu.messages.polled_topic import PolledTopic
from setcmas_simu.ros import qos

SURE_AFTER_S = 0.25
"""Time in s for which nothing but go has come until it counts: who sent a message cannot be known,
but a pause node that means pause says so in between, ten times a second."""

BY_WISH = 'paused'
SILENT = 'paused: nothing is heard of the pause node'
NOT_STARTED = 'paused: the pause node says go, but was not heard to pause first'
SEVERAL = 'paused: several pause nodes send /paused; is another experiment in this ROS domain?'


class PauseWatch:
    """The pause state that a process acts upon: paused unless told otherwise, all the time."""

    def __init__(
        self, node: Node, timeout_s: float = PAUSE_TIMEOUT_S, latches: bool = False
    ) -> None:
        """Listen through a node.

        Args:
            node: The node.
            timeout_s: Age in s from which the last word of the pause node is too old.
            latches: Whether, at first and after every silence or contradiction, go counts only
                once pause has been heard: robots do not start by themselves because a message
                comes back, or because somebody else's pause node says go.
        """
        self._node = node
        self._timeout_s = timeout_s
        self._latches = latches
        self._may_go = not latches
        self._held = ''
        self._paused = True
        self._go_since = float('inf')
        self._received = self._looked = self._comes_from = -float('inf')
        self._topic = PolledTopic(node, Bool, topics.PAUSED, self._on_paused, qos.EVENT)

    def reason(self) -> str:
        """Return why robots are paused, by what has come; empty if they are not."""
        now = time.monotonic()
        # Who latches takes a message for as old as it can be: it came after the last look.
        self._comes_from, self._looked = self._looked if self._latches else now, now
        self._topic.take()
        trouble = self._trouble()
        if trouble:
            if trouble == SEVERAL and self._may_go:
                self._held = SEVERAL  # for whoever asks once they are gone
            self._may_go = not self._latches
            return trouble
        if self._paused:
            self._may_go = True
            self._held = ''
            return BY_WISH
        if not self._may_go:
            return self._held or NOT_STARTED
        return BY_WISH if now - self._go_since < SURE_AFTER_S else ''

    def hold(self, why: str) -> None:
        """Pause, until the pause node says pause and then go again."""
        self._may_go = False
        self._held = f'{BY_WISH}: {why}'

    def forget(self) -> None:
        """Let all that has come count as nothing: this process was held up since."""
        self._topic.take()
        self._received = -float('inf')

    def _trouble(self) -> str:
        # Asked every time: between two looks, a second pause node could start the robots.
        if self._node.count_publishers(topics.PAUSED) > 1:
            return SEVERAL
        silent = time.monotonic() - self._received > self._timeout_s
        return SILENT if silent else ''

    def _on_paused(self, message: Bool) -> None:
        if message.data:
            self._paused, self._go_since = True, float('inf')
        elif self._paused:
            self._paused, self._go_since = False, time.monotonic()
        self._received = self._comes_from
