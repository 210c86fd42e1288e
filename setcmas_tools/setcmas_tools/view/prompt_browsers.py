"""Browsers that answer at once: a press of theirs that starts robots is not an old one.

What is held up on its way, or before this process goes on, holds up the answers behind it: a
connection keeps the order. Browsers answer pings by themselves (RFC 6455, section 5.5.2).
"""

from __future__ import annotations

import asyncio
import contextlib
import math

import viser
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from setcmas_expe.safety.stalls import StallDetector, time_since_boot

_PROMPT_S = 0.5
_ASKS_EVERY_S = 0.1


class PromptBrowsers:
    """Asks all browsers of a page again and again, each for itself."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Ask whoever comes to a page from now on."""
        self._connections = server._websock_server._live_connections  # viser hands out no pings
        self._answers: dict[int | None, StallDetector] = {}
        self._tasks: dict[int, asyncio.Task[None]] = {}
        server.on_client_connect(self._on_connect)
        server.on_client_disconnect(self._on_disconnect)

    def is_prompt(self, browser: int | None) -> bool:
        """Return whether what a browser, by its number, says now is not older than 1 s.

        Its last answer is less than 0.5 s old and took no longer, nor was it late in the last 1 s.
        """
        answers = self._answers.get(browser)
        return answers is not None and not answers.recent(time_since_boot())

    async def _on_connect(self, client: viser.ClientHandle) -> None:
        number = client.client_id
        if connection := self._connections.get(number):
            self._answers[number] = StallDetector(_PROMPT_S, -math.inf)  # no answer so far
            asks = _ask(connection, self._answers[number])
            self._tasks[number] = asyncio.create_task(asks)

    async def _on_disconnect(self, client: viser.ClientHandle) -> None:
        self._answers.pop(client.client_id, None)
        if task := self._tasks.pop(client.client_id, None):
            task.cancel()


async def _ask(connection: ServerConnection, answers: StallDetector) -> None:
    with contextlib.suppress(ConnectionClosed):
        while True:
            asked = time_since_boot()
            await (await connection.ping())
            now = time_since_boot()
            if now - asked <= _PROMPT_S:
                answers.tick(now)
            await asyncio.sleep(_ASKS_EVERY_S)
