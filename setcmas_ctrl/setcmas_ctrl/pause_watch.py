"""Pause and stop of an experiment, as controllers, bridges and guards must obey them.

The pause node (`setcmas_expe.pause`) publishes them; everybody else listens through this file.
"""

from __future__ import annotations

import math
import time

from rclpy.node import Node
from std_msgs.msg import Bool

from setcmas_ctrl.laws.control_options import PAUSE_TIMEOUT_S
from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic

SURE_AFTER_S = 0.25
"""Time in s with only "go" messages before it counts: the sender of a message is unknown, but a
pause node that means pause repeats it ten times a second."""


class PauseWatch:
    """Pause state of this process: paused unless a pause node keeps saying go."""

    def __init__(
        self, node: Node, timeout_s: float = PAUSE_TIMEOUT_S, latches: bool = False
    ) -> None:
        """Subscribe through a node.

        Args:
            node: Creates the subscription.
            timeout_s: Longest silence of the pause node before robots stop.
            latches: Whether go counts only after pause, at first and after each silence or
                contradiction: robots must not start by themselves when messages come back, or
                because another pause node says go.
        """
        self._node = node
        self._timeout_s = timeout_s
        self._latches = latches
        self._may_go = not latches
        self._held = _reason(PauseCause.NOT_STARTED)
        self._paused = True
        self._go_since = math.inf
        self._received = self._looked = self._comes_from = -math.inf
        self._topic = PolledTopic(node, Bool, topics.PAUSED, self._on_paused, qos.EVENT)

    def reason(self) -> PauseReason | None:
        """Return why robots are paused; None if they are not."""
        now = time.monotonic()
        # If it latches, count the message as old as possible: it came after the last check.
        self._comes_from, self._looked = self._looked if self._latches else now, now
        self._topic.take()
        trouble = self._trouble()
        if trouble:
            if trouble is PauseCause.SEVERAL and self._may_go:
                self._held = _reason(trouble)  # also for later checks, when they are gone
            self._may_go = not self._latches
            return _reason(trouble)
        if self._paused:
            self._may_go = True
            self._held = _reason(PauseCause.NOT_STARTED)
            return _reason(PauseCause.OPERATOR)
        if not self._may_go:
            return self._held
        is_sure = now - self._go_since >= SURE_AFTER_S
        return None if is_sure else _reason(PauseCause.OPERATOR)

    @property
    def is_on(self) -> bool:
        """Whether robots are paused."""
        return self.reason() is not None

    def latch(self, why: str) -> None:
        """Pause until the pause node says pause and then go again."""
        self._may_go = False
        self._held = PauseReason(PauseCause.LATCHED, why)

    def forget(self) -> None:
        """Forget all messages, because this process was suspended."""
        self._topic.take()
        self._received = -math.inf

    def _trouble(self) -> PauseCause | None:
        # Check every time: a second pause node could start the robots between two checks.
        if self._node.count_publishers(topics.PAUSED) > 1:
            return PauseCause.SEVERAL
        silent = time.monotonic() - self._received > self._timeout_s
        return PauseCause.SILENT if silent else None

    def _on_paused(self, message: Bool) -> None:
        if message.data:
            self._paused, self._go_since = True, math.inf
        elif self._paused:
            self._paused, self._go_since = False, time.monotonic()
        self._received = self._comes_from


def _reason(cause: PauseCause) -> PauseReason:
    return PauseReason(cause, cause.value)


class EmergencyWatch:
    """Latches a stop until the pause node that took it over releases it.

    Any node may stop the robots. A pause node ends the stop by publishing "not stopped" after it
    has published "stopped", and only while no other node publishes that.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.stopped = False
        self._is_taken_over = False
        self._nb_publishers = 0
        self._free_since = math.inf
        stop, state = topics.EMERGENCY_STOP, topics.EMERGENCY_STOPPED
        self._topics = [
            *(PolledTopic(node, Bool, stop, self._on_stop, one) for one in qos.FROM_ANYBODY),
            PolledTopic(node, Bool, state, self._on_state, qos.LATCHED_BY_MANY),
        ]

    def take(self) -> bool:
        """Take messages; return whether robots must stop."""
        before = self._nb_publishers
        self._nb_publishers = self._node.count_publishers(topics.EMERGENCY_STOPPED)
        for topic in self._topics:
            topic.take()
        # A message may be older than the count: what came from two says nothing of the last one.
        if before != 1 or self._nb_publishers != 1:
            self._is_taken_over = False  # a new pause node must take it over, too
        return self.stopped

    def _on_stop(self, message: Bool) -> None:
        if message.data and not self.stopped:
            self.stopped, self._is_taken_over, self._free_since = True, False, math.inf

    def _on_state(self, message: Bool) -> None:
        if message.data:
            self.stopped, self._is_taken_over, self._free_since = True, True, math.inf
        elif self._is_taken_over:
            # Messages do not name their sender, but the pause node repeats its own in between.
            now = time.monotonic()
            self._free_since = min(self._free_since, now)
            if now - self._free_since >= SURE_AFTER_S:
                self.stopped = self._is_taken_over = False
