"""Topics and services polled at each step, without an executor, and topics on demand."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.parameter_service import ParameterService
from rclpy.qos import QoSProfile
from rclpy.service import Service


class _NeverCalledBack(CallbackGroup):
    """Callback group that an executor skips although it serves the node."""

    def add_entity(self, _: object) -> None:
        pass

    def can_execute(self, _: object) -> bool:
        return False


POLLED = _NeverCalledBack()
"""Callback group of what is polled."""
UNREADABLE = rclpy_implementation.RMWError
"""Raised for a message that its sender has cut short."""


class PolledTopic:
    """Passes the messages of a topic to a function when `take` is called.

    An executor would wake up for each message and rebuild its wait set every time.
    """

    def __init__(
        self,
        node: Node,
        kind: type,
        name: str,
        on_message: Callable[[Any], None],
        profile: QoSProfile,
    ) -> None:
        """Subscribe to a topic; the depth of its profile bounds the queue.

        Messages that another process has cut short are left out.
        """
        self._node = node
        self._on_message = on_message
        self._depth = profile.depth
        self.subscription = node.create_subscription(
            kind, name, on_message, profile, callback_group=POLLED
        )

    def take(self) -> None:
        """Pass on pending messages."""
        handle = self.subscription.handle
        with handle:
            for _ in range(self._depth):
                try:
                    taken = handle.take_message(self.subscription.msg_type, False)
                except UNREADABLE:
                    continue
                if taken is None:
                    return
                self._on_message(taken[0])

    def close(self) -> None:
        """Unsubscribe."""
        self._node.destroy_subscription(self.subscription)


class RequestWait:
    """Waits, and meanwhile answers requests to the services of some nodes.

    One wait set serves all nodes of a process; an executor, which must not serve them as well,
    would build its own at every turn.
    """

    def __init__(
        self,
        nodes: Sequence[Node],
        urgent: Sequence[PolledTopic] = (),
        late: Sequence[Node] = (),
    ) -> None:
        """Serve the present services of nodes, and topics whose messages cannot wait.

        Late nodes, which have no services for their parameters yet, get them by `start_services`.
        Those of one node take 3 ms: those of 8 robots would delay their first command by 0.1 s
        of processor time (benchmarks/fleet.py, 2 cores of an AMD EPYC).
        """
        self._context = nodes[0].context.handle
        self._late = [node for node in late if not any(node.services)]
        self._services: dict[int, Service] = {}
        self._topics = {one.subscription.handle.pointer: one for one in urgent}
        self._serve(nodes)

    def start_services(self, within_s: float = math.inf) -> None:
        """Start the parameter services of the next late node, and of more within a time in s."""
        deadline = time.monotonic() + within_s
        started: list[Node] = []
        while self._late and (not started or time.monotonic() < deadline):
            started.append(self._late.pop(0))
            ParameterService(started[-1])
        if started:
            self._serve(started)

    def _serve(self, nodes: Sequence[Node]) -> None:
        self._services |= {one.handle.pointer: one for node in nodes for one in node.services}
        self._waiting = rclpy_implementation.WaitSet(
            len(self._topics), 0, 0, 0, len(self._services), 0, self._context
        )

    def wait(self, timeout_s: float) -> None:
        """Wait until the first request or message, which is answered, or a time-out."""
        waiting = self._waiting
        waiting.clear_entities()
        for service in self._services.values():
            waiting.add_service(service.handle)
        for topic in self._topics.values():
            waiting.add_subscription(topic.subscription.handle)
        waiting.wait(round(max(0.0, timeout_s) * 1e9))
        for pointer in waiting.get_ready_entities('service'):
            answer(self._services[pointer])
        for pointer in waiting.get_ready_entities('subscription'):
            self._topics[pointer].take()


def answer(service: Service) -> None:
    """Answer a pending request to a service, if there is one."""
    kind: Any = service.srv_type
    with service.handle:
        request, sender = service.handle.service_take_request(kind.Request)
    if sender is not None:
        service.send_response(service.callback(request, kind.Response()), sender)


def wait_for_message(node: Node, topic: PolledTopic, timeout_s: float) -> None:
    """Wait until a topic has a message, which is not taken, or a time-out.

    An executor would check every entity of its nodes instead.
    """
    waiting = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)
    waiting.clear_entities()
    waiting.add_subscription(topic.subscription.handle)
    waiting.wait(round(timeout_s * 1e9))
