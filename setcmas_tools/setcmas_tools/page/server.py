"""Web server of the page: one document, and its live messages over a websocket.

Only `websockets` is used: a page without files of its own needs no framework.
"""

from __future__ import annotations

import asyncio
import errno
import ipaddress
import logging
import os
import queue
import secrets
import signal
import socket
import sys
import threading
import webbrowser
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from enum import Enum
from http import HTTPStatus
from typing import Any
from urllib.parse import SplitResult, parse_qs, urlsplit

import msgspec
from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from setcmas_simu.errors import SetcmasError
from setcmas_tools.page.browser import (
    EVERYWHERE,
    BrowserOptions,
    may_open_windows,
    own_address,
)

LIVE = '/live'
_PORTS_TRIED = 50
_MOST_PRESSED = 100
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


class Button(Enum):
    """What a button of the page asks for; the last two are for simulations only."""

    STOP = 'stop'
    PAUSE = 'pause'
    START = 'start'
    RESET = 'reset'


class LiveSummary:
    """The newest state and the last poses of a live run, for browsers that connect later.

    It is used by the thread of the server only.
    """

    MOST_FRAMES = 1200
    """Poses of two minutes."""

    def __init__(self) -> None:
        self._newest: dict[str, Mapping[str, Any]] = {}
        self._begin()

    def _begin(self) -> None:
        self._items: dict[str, dict[Any, Any]] = {
            kind: {} for kind in ('looks', 'states', 'links', 'shapes')
        }
        self._frames: deque[Mapping[str, Any]] = deque(maxlen=self.MOST_FRAMES)

    def take(self, message: Mapping[str, Any]) -> None:
        """Take a message that all browsers get."""
        kind = message['kind']
        if kind == 'begin':
            self._begin()
        elif kind == 'frame':
            self._frames.append(message)
        elif kind in self._items:
            self._items[kind] |= dict(message['items'])
        elif kind in ('status', 'now'):
            self._newest[kind] = message

    def messages(self) -> list[Mapping[str, Any]]:
        """Return the messages that bring a new browser up to date."""
        now = self._newest.get('now', {'kind': 'now', 't': 0.0})
        t = self._frames[0]['t'] if self._frames else now['t']
        known = {
            kind: [pair for pair in items.items() if pair[1] is not None]
            for kind, items in self._items.items()
        }
        return [
            *([self._newest['status']] if 'status' in self._newest else []),
            {'kind': 'begin'},
            *({'kind': kind, 't': t, 'items': items} for kind, items in known.items()),
            *self._frames,
            now,
        ]


class PageServer:
    """Serves a page from a thread of its own.

    Attributes:
        url: Address of the page on this machine.
        query: End of its address: its token, if it needs one.
        pressed: Buttons that were pressed, for the process that started the server.
    """

    def __init__(
        self,
        text: str,
        host: str,
        port: int,
        is_live: bool = False,
        has_buttons: bool = False,
        needs_token: bool = False,
    ) -> None:
        """Serve at a host's address, at a port or the next free one.

        Args:
            text: The page.
            host: The address.
            port: The port.
            is_live: Whether browsers that show the page get messages.
            has_buttons: Whether its buttons command robots.
            needs_token: Whether only people with the token may open the page.

        Raises:
            SetcmasError: No port is free, or the address is not one of this machine.
        """
        self._socket = _bound_socket(host, port)
        self.port = int(self._socket.getsockname()[1])
        self._token = secrets.token_urlsafe() if needs_token else ''
        self.query = f'/?token={self._token}' if needs_token else ''
        self.url = address_url(EVERYWHERE.get(host, host), self.port) + self.query
        self._names = names_of_this_machine() | {host.lower()}
        self._page = text.encode(errors='replace')
        self._is_live, self._has_buttons = is_live, has_buttons
        self.pressed: queue.Queue[Button] = queue.Queue(_MOST_PRESSED)
        self._summary = LiveSummary()
        self._viewers: set[ServerConnection] = set()
        self._loop = asyncio.new_event_loop()
        self._stopping = asyncio.Event()
        self._thread = threading.Thread(
            target=self._loop.run_until_complete, args=(self._serve(),), daemon=True
        )
        self._thread.start()

    def has_viewers(self) -> bool:
        """Return whether a browser shows the live page."""
        return bool(self._viewers)

    def send(self, messages: Sequence[Mapping[str, Any]]) -> None:
        """Send messages to all browsers soon; return at once."""
        self._loop.call_soon_threadsafe(self._send, messages)

    def stop(self) -> None:
        """Stop serving."""
        self._loop.call_soon_threadsafe(self._stopping.set)
        self._thread.join()
        self._loop.close()

    async def _serve(self) -> None:
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
            await self._stopping.wait()
            for connection in server.connections:
                connection.transport.abort()

    def _answer(self, _: ServerConnection, request: Request) -> Response | None:
        """Return the answer to a request; None lets a websocket begin."""
        headers, address = request.headers, urlsplit(request.path)
        host, origins = ', '.join(headers.get_all('Host')), headers.get_all('Origin')
        if reason := refusal(host, ', '.join(origins) if origins else None, self._names):
            return _text(HTTPStatus.FORBIDDEN, reason)
        given = ''.join(parse_qs(address.query).get('token', []))
        if self._token and not secrets.compare_digest(given.encode(), self._token.encode()):
            return _text(HTTPStatus.FORBIDDEN, _NO_TOKEN)
        if address.path == LIVE and self._is_live:
            return None
        if address.path != '/':
            return _text(HTTPStatus.NOT_FOUND, 'the only page is /')
        return _response(HTTPStatus.OK, 'text/html; charset=utf-8', self._page)

    async def _talk(self, connection: ServerConnection) -> None:
        # No await between these lines, so that no message is missed. `websockets` closes the
        # connection to a browser that no longer reads after 40 s.
        broadcast([connection], _encoded(self._summary.messages()))
        self._viewers.add(connection)
        try:
            async for message in connection:
                if not self._has_buttons:
                    break
                self.pressed.put_nowait(Button(message))
        except (ValueError, queue.Full):  # no button of this page sends that, or that often
            pass
        finally:
            self._viewers.remove(connection)

    def _send(self, messages: Sequence[Mapping[str, Any]]) -> None:
        for message in messages:
            self._summary.take(message)
        broadcast(self._viewers, _encoded(messages))


def announce(server: PageServer, options: BrowserOptions) -> None:
    """Print the address of the page, and who else may press its buttons."""
    taken = '' if server.port == options.port else f' (port {options.port} is taken)'
    print(f'browser view: {server.url}{taken}', flush=True)
    if options.host in EVERYWHERE:
        other = address_url(own_address() or socket.gethostname(), server.port) + server.query
        print(f'browser view for other machines: {other}', flush=True)
    if server.query:
        print(
            f'warning: with --host {options.host} whoever has this address can press the buttons '
            'that pause, stop, start and reset robots; --read-only removes them',
            file=sys.stderr,
            flush=True,
        )


def show_page(text: str, browser: BrowserOptions) -> None:
    """Serve a page until Ctrl-C, or raise SetcmasError."""
    stop = threading.Event()
    before = {
        number: signal.signal(number, lambda *_: stop.set())
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    server = PageServer(text, browser.host, browser.port)
    try:
        announce(server, browser)
        if may_open_windows(os.environ, sys.platform):
            webbrowser.open(server.url)
        while not stop.wait(0.5):  # signals are handled between waits on Windows
            pass
    finally:
        server.stop()
        for number, handler in before.items():
            signal.signal(number, handler)


def _encoded(messages: Sequence[Mapping[str, Any]]) -> str:
    return msgspec.json.encode(messages).decode()


def _text(status: HTTPStatus, text: str) -> Response:
    return _response(status, 'text/plain; charset=utf-8', f'{text}\n'.encode(errors='replace'))


def _response(status: HTTPStatus, kind: str, body: bytes) -> Response:
    own = {'Content-Type': kind, 'Content-Length': str(len(body)), 'Connection': 'close'}
    return Response(status.value, status.phrase, Headers(own | _HEADERS), body)


def names_of_this_machine() -> set[str]:
    """Return the names, in lower case, under which a browser may ask for the page."""
    name = socket.gethostname().lower()
    short = name.partition('.')[0]
    return {'localhost', name, short, f'{short}.local'}


def refusal(host: str, origin: str | None, names: Collection[str]) -> str:
    """Return why a request is refused; an empty text if it is not.

    A browser lets every page, wherever it is from, open a websocket to every server that it can
    reach, so the server has to check the Origin (RFC 6455, section 10.2).

    Args:
        host: Its Host header: the name that the browser has asked for.
        origin: Its Origin header: the page that asks; None for programs other than browsers.
        names: Names of this machine. A stranger's name for its address (DNS rebinding) would
            make that stranger's page its own origin; addresses cannot be invented like that.
    """
    name = _split(f'//{host}').hostname or ''
    if not name or not (name in names or _is_address(name)):
        return f"this page is not called '{host}'; open it by its address, or as localhost"
    if origin is not None and _split(origin).netloc.lower() != host.lower():
        return f"pages of '{origin}' may not use this one"
    return ''


def _split(address: str) -> SplitResult:
    try:
        return urlsplit(address)
    except ValueError:  # brackets that do not fit
        return SplitResult('', '', '', '', '')


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _bound_socket(host: str, port: int) -> socket.socket:
    """Return a socket at the first free port of a host's address, from one on.

    Raises:
        SetcmasError: None is free, or the address is not one of this machine.
    """
    last = min(port + _PORTS_TRIED, 65536) - 1
    for candidate in range(port, last + 1):
        try:
            family, _, _, _, address = socket.getaddrinfo(
                host, candidate, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
            )[0]
            both = family == socket.AF_INET6  # `::` serves IPv4, too
            return socket.create_server(address, family=family, dualstack_ipv6=both)
        except OSError as error:
            _check(error, host, candidate)
    raise SetcmasError(f'ports {port} to {last} are all taken; name another with --port')


def _check(error: OSError, host: str, port: int) -> None:
    """Pass over a port that is taken."""
    if error.errno == errno.EADDRINUSE:
        return
    if error.errno in (errno.EACCES, errno.EPERM):
        raise SetcmasError(f'port {port} is not allowed; ports from 1024 are (--port)') from None
    raise SetcmasError(
        f"host '{host}' is not an address of this machine; it must be 127.0.0.1, 0.0.0.0 "
        'or an address that `hostname -I` prints'
    ) from None


def address_url(host: str, port: int) -> str:
    """Return the address of a page."""
    return f'http://[{host}]:{port}' if ':' in host else f'http://{host}:{port}'
