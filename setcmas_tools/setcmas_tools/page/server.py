"""Web server of the page: one document, and its live messages over a websocket.

Only `websockets` is used: a page without files of its own needs no framework.
"""

from __future__ import annotations

import asyncio
import errno
import logging
import os
import re
import secrets
import socket
import sys
import webbrowser
from collections.abc import AsyncIterator, Callable, Collection, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from enum import Enum
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs, urlsplit

import msgspec
from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.http11 import Request, Response

from setcmas_simu.errors import SetcmasError
from setcmas_tools.page.browser import (
    EVERYWHERE,
    BrowserOptions,
    may_open_windows,
    own_address,
)

LIVE = '/live'
_LARGEST_BYTES = 256
_HANDSHAKE_S = 5.0
_NO_TOKEN = 'open the whole address that setcmas has printed, with its token'
_HEADERS = {
    'Cache-Control': 'no-store',
    'Referrer-Policy': 'no-referrer',
    'X-Content-Type-Options': 'nosniff',
    'X-Frame-Options': 'DENY',  # no other page may show this one and catch clicks
}
_SILENT = logging.getLogger('setcmas.page')
_SILENT.addHandler(logging.NullHandler())
_SILENT.propagate = False


Message = Mapping[str, Any]


class Button(Enum):
    """What a button of the page asks for; the last two are for simulations only."""

    STOP = 'stop'
    PAUSE = 'pause'
    START = 'start'
    RESET = 'reset'


class PageServer:
    """Serves a page, and messages to the browsers that show it.

    Attributes:
        url: Address of the page on this machine.
    """

    def __init__(
        self,
        text: str,
        options: BrowserOptions,
        first_messages: Callable[[], Sequence[Message]] | None = None,
        on_button: Callable[[Button], None] | None = None,
    ) -> None:
        """Find a port: that of the options, or a free one.

        Args:
            text: The page.
            options: Where it is served.
            first_messages: Returns what a browser gets first; None for a page without messages.
            on_button: Called with each button that is pressed; None for a page without buttons.

        Raises:
            SetcmasError: The port is not allowed, or the address is not one of this machine.
        """
        self._page, self._options = text, options
        self._first_messages, self._on_button = first_messages, on_button
        self._socket = _bound_socket(options.host, options.port)
        self._port = int(self._socket.getsockname()[1])
        has_token = on_button is not None and not options.is_local
        self._token = secrets.token_urlsafe() if has_token else ''
        self.url = self._url(EVERYWHERE.get(options.host, options.host))
        self._names = names_of_this_machine() | {options.host.lower()}
        self._viewers: set[ServerConnection] = set()

    def _url(self, host: str) -> str:
        query = f'/?token={self._token}' if self._token else ''
        return f'http://{f"[{host}]" if ":" in host else host}:{self._port}{query}'

    @property
    def has_viewers(self) -> bool:
        """Whether a browser shows the page and gets messages."""
        return bool(self._viewers)

    def send(self, messages: Sequence[Message]) -> None:
        """Send messages to all browsers soon; return at once."""
        broadcast(self._viewers, _encoded(messages))

    @asynccontextmanager
    async def serving(self) -> AsyncIterator[None]:
        """Serve, and print the address of the page."""
        async with serve(
            self._talk,
            sock=self._socket,
            process_request=self._answer,
            compression=None,
            max_size=_LARGEST_BYTES,
            max_queue=4,
            open_timeout=_HANDSHAKE_S,
            close_timeout=1.0,
            logger=_SILENT,
            server_header=None,
        ) as server:
            self._announce()
            try:
                yield
            finally:
                for connection in server.connections:
                    connection.transport.abort()

    def _announce(self) -> None:
        """Print the address of the page, and who else may press its buttons."""
        port, host = self._options.port, self._options.host
        taken = '' if self._port == port else f' (port {port} is taken)'
        print(f'browser view: {self.url}{taken}', flush=True)
        if host in EVERYWHERE:
            other = self._url(own_address() or socket.gethostname())
            print(f'browser view for other machines: {other}', flush=True)
        if self._token:
            print(
                f'warning: with --host {host} whoever has this address can press the buttons '
                'that pause, stop, start and reset robots; --read-only removes them',
                file=sys.stderr,
                flush=True,
            )

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the answer to a request; None lets a websocket begin."""
        headers, address = request.headers, urlsplit(request.path)
        host, origins = ', '.join(headers.get_all('Host')), headers.get_all('Origin')
        if reason := refusal(host, ', '.join(origins), self._names):
            return _response(connection, HTTPStatus.FORBIDDEN, reason)
        given = ''.join(parse_qs(address.query).get('token', []))
        if self._token and not secrets.compare_digest(given.encode(), self._token.encode()):
            return _response(connection, HTTPStatus.FORBIDDEN, _NO_TOKEN)
        if address.path == LIVE and self._first_messages:
            return None
        if address.path != '/':
            return _response(connection, HTTPStatus.NOT_FOUND, 'the only page is /')
        return _response(connection, HTTPStatus.OK, self._page)

    async def _talk(self, connection: ServerConnection) -> None:
        # No await between these lines, so that no message is missed. `websockets` closes the
        # connection to a browser that no longer reads after 40 s.
        if self._first_messages:
            broadcast([connection], _encoded(self._first_messages()))
        self._viewers.add(connection)
        try:
            async for message in connection:
                if not self._on_button:
                    break
                self._on_button(Button(message))
        except ValueError:  # no button of this page sends that
            pass
        finally:
            self._viewers.remove(connection)


def show_page(text: str, options: BrowserOptions) -> None:
    """Serve a page until Ctrl-C, or raise SetcmasError."""
    server = PageServer(text, options)

    async def show() -> None:
        async with server.serving():
            if may_open_windows(os.environ, sys.platform):
                webbrowser.open(server.url)
            await asyncio.Event().wait()

    with suppress(KeyboardInterrupt):
        asyncio.run(show())


def _response(connection: ServerConnection, status: HTTPStatus, text: str) -> Response:
    response = connection.respond(status, text.encode(errors='replace').decode())
    if status is HTTPStatus.OK:
        del response.headers['Content-Type']
        response.headers['Content-Type'] = 'text/html; charset=utf-8'
    response.headers.update(_HEADERS)
    return response


def _encoded(messages: Sequence[Message]) -> str:
    return msgspec.json.encode(messages).decode()


def names_of_this_machine() -> set[str]:
    """Return the names, in lower case, under which a browser may ask for the page."""
    name = socket.gethostname().lower()
    short = name.partition('.')[0]
    return {'localhost', name, short, f'{short}.local'}


_ADDRESS = re.compile(r'(\[[0-9a-f:.]+\]|[0-9.]+)(:[0-9]+)?')


def refusal(host: str, origin: str, names: Collection[str]) -> str:
    """Return why a request is refused; an empty text if it is not.

    A browser lets every page, wherever it is from, open a websocket to every server that it can
    reach, so the server has to check the Origin (RFC 6455, section 10.2).

    Args:
        host: Its Host header: the name that the browser has asked for.
        origin: Its Origin header: the page that asks; '' for programs other than browsers.
        names: Names of this machine. A stranger's name for its address (DNS rebinding) would
            make that stranger's page its own origin; addresses cannot be invented like that.
    """
    asked = host.lower()
    if asked.partition(':')[0] not in names and not _ADDRESS.fullmatch(asked):
        return f"this page is not called '{host}'; open it by its address, or as localhost"
    if origin and origin.lower() not in (f'http://{asked}', f'https://{asked}'):
        return f"pages of '{origin}' may not use this one"
    return ''


def _bound_socket(host: str, port: int) -> socket.socket:
    """Return a socket at a port of a host's address, or at any free one if it is taken.

    Raises:
        SetcmasError: The port is not allowed, or the address is not one of this machine.
    """
    is_v6 = ':' in host
    family = socket.AF_INET6 if is_v6 else socket.AF_INET
    try:  # `::` serves IPv4, too
        return socket.create_server((host, port), family=family, dualstack_ipv6=is_v6)
    except PermissionError:
        raise SetcmasError(f'port {port} is not allowed; ports from 1024 are (--port)') from None
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return _bound_socket(host, 0)
        raise SetcmasError(
            f"host '{host}' is not an address of this machine; it must be 127.0.0.1, 0.0.0.0 "
            'or an address that `hostname -I` prints'
        ) from None
