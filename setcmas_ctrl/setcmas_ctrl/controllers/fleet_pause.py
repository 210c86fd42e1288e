"""Pause and emergency stop of a controller process: who asks for them, and who ends them."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import SetBool

from setcmas_ctrl.control.control_options import PAUSE_TIMEOUT_S
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.fleet import topics
from setcmas_simu.reports.reports import Launcher, Paused
from setcmas_simu.ros import qos
from setcmas_simu.ros.polling import PolledTopic

_MOST_LINES = 10  # in _FLOOD_S
_FLOOD_S = 10.0


class FleetPause:
    """Pauses and resumes robots, and reports it to the launcher.

    Attributes:
        topics: Its topics, to be taken often.
    """

    def __init__(self, node: Node, drivers: Sequence[SiToUni], launcher: Launcher) -> None:
        """Subscribe and offer the service through a node."""
        self._drivers = drivers
        self._launcher = launcher
        self._stopped = self._requested = False
        self._printed: list[float] = []
        node.create_service(SetBool, '~/pause', self._answer)
        stop = topics.EMERGENCY_STOP
        self.topics = [
            PolledTopic(node, Bool, topics.FLEET_PAUSE, self._on_pause, qos.EVENT),
            # Each profile matches publishers that the other does not.
            *(
                PolledTopic(node, Bool, stop, self._on_stop, one)
                for one in (qos.EVENT, qos.LATCHED)
            ),
        ]

    @property
    def is_on(self) -> bool:
        """Whether all robots are paused."""
        if not self._drivers:  # controllers whose robots other processes drive
            return self._requested
        return all(driver.paused for driver in self._drivers)

    def _on_stop(self, message: Bool) -> None:
        if message.data and not self._stopped:
            self._pause(True, topics.EMERGENCY_STOP)
            print('emergency stop: restart this process to continue', flush=True)
            self._stopped = True
            for driver in self._drivers:
                driver.stopped = True

    def _on_pause(self, message: Bool) -> None:
        self._pause(message.data, '/pause')

    def _pause(self, paused: bool, by: str) -> None:
        if self._stopped:
            return
        if self._requested != paused or any(one.paused != paused for one in self._drivers):
            self._print(f'{"paused" if paused else "started"} by {by}')
            self._launcher.report(Paused(paused))
        self._requested = paused
        for driver in self._drivers:
            driver.pause(paused)

    def _print(self, line: str) -> None:
        """Print a line, unless a flood of requests would fill the terminal."""
        now = time.monotonic()
        self._printed = [at for at in self._printed if now - at < _FLOOD_S]
        if len(self._printed) < _MOST_LINES:
            self._printed.append(now)
            rest = len(self._printed) == _MOST_LINES
            print(f'{line}{"; similar lines are hidden for now" if rest else ""}', flush=True)

    def _answer(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._pause(request.data, 'service')
        response.success = request.data or not self._stopped
        paused = request.data or self._stopped
        response.message = f'all robots are {"paused" if paused else "resumed"}'
        return response


SURE_AFTER_S = 0.25
"""Time in s with only "go" messages before it counts: the sender of a message is unknown, but a
pause node that means pause repeats it ten times a second."""

PAUSED = 'paused'
PAUSE_NODE_SILENT = 'paused: no message from the pause node'
NOT_STARTED = 'paused: the pause node sent a start without a pause before it'
SEVERAL = 'paused: several pause nodes publish /paused; is another experiment in this ROS domain?'


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
        self._held = ''
        self._paused = True
        self._go_since = float('inf')
        self._received = self._looked = self._comes_from = -float('inf')
        self._topic = PolledTopic(node, Bool, topics.PAUSED, self._on_paused, qos.EVENT)

    def reason(self) -> str:
        """Return why robots are paused; '' if they are not."""
        now = time.monotonic()
        # If it latches, count the message as old as possible: it came after the last check.
        self._comes_from, self._looked = self._looked if self._latches else now, now
        self._topic.take()
        trouble = self._trouble()
        if trouble:
            if trouble == SEVERAL and self._may_go:
                self._held = SEVERAL  # also for later checks, when they are gone
            self._may_go = not self._latches
            return trouble
        if self._paused:
            self._may_go = True
            self._held = ''
            return PAUSED
        if not self._may_go:
            return self._held or NOT_STARTED
        return PAUSED if now - self._go_since < SURE_AFTER_S else ''

    def latch(self, why: str) -> None:
        """Pause until the pause node says pause and then go again."""
        self._may_go = False
        self._held = f'{PAUSED}: {why}'

    def forget(self) -> None:
        """Forget all messages, because this process was suspended."""
        self._topic.take()
        self._received = -float('inf')

    def _trouble(self) -> str:
        # Check every time: a second pause node could start the robots between two checks.
        if self._node.count_publishers(topics.PAUSED) > 1:
            return SEVERAL
        silent = time.monotonic() - self._received > self._timeout_s
        return PAUSE_NODE_SILENT if silent else ''

    def _on_paused(self, message: Bool) -> None:
        if message.data:
            self._paused, self._go_since = True, float('inf')
        elif self._paused:
            self._paused, self._go_since = False, time.monotonic()
        self._received = self._comes_from


STOPPED = 'emergency stop'


class EmergencyWatch:
    """Latches an emergency stop until the pause node that took it over releases it.

    Any node may stop the robots. Only the pause node that has since published "stopped" ends the
    stop by publishing "not stopped", and only while there is no other pause node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.stopped = False
        self._holder: bytes | None = None
        self._free_since: float | None = None
        stop, state = topics.EMERGENCY_STOP, topics.EMERGENCY_STOPPED
        # The first profile matches publishers without latching, the second latching ones.
        self._topics = [
            PolledTopic(node, Bool, stop, self._on_stop, qos.EVENT),
            PolledTopic(node, Bool, stop, self._on_stop, qos.LATCHED),
            PolledTopic(node, Bool, state, self._on_state, qos.LATCHED_BY_MANY),
        ]

    def take(self) -> bool:
        """Take messages; return whether robots must stop."""
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
            # Messages do not name their sender, but the pause node repeats its own in between.
            now = time.monotonic()
            self._free_since = self._free_since or now
            if now - self._free_since >= SURE_AFTER_S:
                self.stopped, self._holder = False, None

    def _only_source(self) -> bytes | None:
        found = self._node.get_publishers_info_by_topic(topics.EMERGENCY_STOPPED)
        return bytes(found[0].endpoint_gid) if len(found) == 1 else None
