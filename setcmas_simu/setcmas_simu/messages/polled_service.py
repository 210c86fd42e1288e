"""Service whose requests are polled, without an executor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

MOST_WITH_SERVICES = 50
"""Largest number of robots in a process for which each robot has its own services."""


class PolledService:
    """Answers requests when `take` is called.

    Each service costs every process on the network 0.1 MB, and an executor a place in its wait
    set.
    """

    def __init__(
        self, node: Node, kind: Any, name: str, answer: Callable[[Any, Any], Any]
    ) -> None:
        """Offer the service.

        Args:
            node: Holds the service; no executor serves it.
            kind: Class of the service.
            name: Its name; `~/` is the node's namespace and name.
            answer: Takes a request and an empty response; returns the response.
        """
        self._kind = kind
        self._answer = answer
        self._service = node.create_service(kind, name, answer)

    def take(self) -> None:
        """Answer pending requests."""
        handle = self._service.handle
        while True:
            with handle:
                request, header = handle.service_take_request(self._kind.Request)
            if header is None:
                return
            self._service.send_response(self._answer(request, self._kind.Response()), header)
