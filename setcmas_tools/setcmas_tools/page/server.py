"""Web server of the page: one document, and its live messages over a websocket.

Only `websockets` is used: a page without files of its own needs no framework.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import ipaddress
import logging
import queue
import secrets
import socket
import sys
import threading
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import Future
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import SplitResult, parse_qs, urlsplit

import msgspec
from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from setcmas_simu.errors import SetcmasError
from setcmas_tools.page.browser import EVERYWHERE, BrowserOptions
from setcmas_tools.page.feed import Feed

LIVE = '/live'
_PORTS_TRIED = 50
_MOST_VIEWERS = 100
_MOST_WAITING = 100
"""Messages queued for a slow browser; beyond, its connection is closed, and it reconnects."""
_MOST_ASKED = 100
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


class StopButton(msgspec.Struct, tag_field='kind', tag='stop', forbid_unknown_fields=True):
    """A stop of all robots."""


class PauseButton(msgspec.Struct, tag_field='kind', tag='pause', forbid_unknown_fields=True):
    """A pause of all robots; `on` is false for their start, in a simulation."""

    on: bool


class ResetButton(msgspec.Struct, tag_field='kind', tag='reset', forbid_unknown_fields=True):
    """All robots of a simulation back to their start poses."""


Action = StopButton | PauseButton | ResetButton
_ACTIONS: msgspec.json.Decoder[Action] = msgspec.json.Decoder(Action)


class PageServer:
    """Serves a page from a thread of its own.

    Attributes:
        url: Address of the page on this machine.
        query: End of its address: its token, if it needs one.
        actions: Requests from buttons, for the process that started the server.
    """

    def __init__(
        self,
        text: str,
        host: str,
        port: int,
        needs_token: bool = False,
        feed: Feed | None = None,
        takes_actions: bool = False,
    ) -> None:
        """Serve at a host's address, at a port or the next free one.

        Args:
            text: The page.
            host: The address.
            port: The port.
            needs_token: Whether only people with the token may open the page.
            feed: Messages of a live page.
            takes_actions: Whether the buttons of a live page command robots.

        Raises:
            SetcmasError: No port is free, or the address is not one of this machine.
        """
        self._socket = _bound_socket(host, port)
        self.port = int(self._socket.getsockname()[1])
        self._token = Token(self.port) if needs_token else None
        self.query = self._token.query if self._token else ''
        self.url = address_url(EVERYWHERE.get(host, host), self.port) + self.query
        self._names = names_of_this_machine() | {host.lower()}
        self._page = text.encode(errors='replace')
        self._feed, self._takes_actions = feed, takes_actions
        self.actions: queue.Queue[Action] = queue.Queue(_MOST_ASKED)
        self._viewers: dict[ServerConnection, asyncio.Queue[bytes]] = {}
        self._loop = asyncio.new_event_loop()
        self._stopping = asyncio.Event()
        started: Future[None] = Future()
        self._thread = threading.Thread(
            target=self._loop.run_until_complete, args=(self._serve(started),), daemon=True
        )
        self._thread.start()
        try:
            started.result()
        except BaseException:
            self._thread.join()
            self._loop.close()
            self._socket.close()
            raise

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

    async def _serve(self, started: Future[None]) -> None:
        try:
            await self._serve_until_stopped(started)
        except BaseException as error:
            if started.done():
                raise
            started.set_exception(error)

    async def _serve_until_stopped(self, started: Future[None]) -> None:
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
            started.set_result(None)
            await self._stopping.wait()
            await _close(server)

    def _answer(self, _: ServerConnection, request: Request) -> Response | None:
        """Return the answer to a request; None lets a websocket begin."""
        headers, address = request.headers, urlsplit(request.path)
        host, origins = ', '.join(headers.get_all('Host')), headers.get_all('Origin')
        if reason := refusal(host, ', '.join(origins) if origins else None, self._names):
            return _text(HTTPStatus.FORBIDDEN, reason)
        token = self._token
        in_address = token is not None and token.is_in_address(request.path)
        if token and not in_address and not token.is_kept('; '.join(headers.get_all('Cookie'))):
            return _text(HTTPStatus.FORBIDDEN, _NO_TOKEN)
        if address.path == LIVE and self._feed:
            if len(self._viewers) < _MOST_VIEWERS:
                return None
            return _text(HTTPStatus.SERVICE_UNAVAILABLE, 'too many browsers show this page')
        if address.path != '/':
            return _text(HTTPStatus.NOT_FOUND, 'the only page is /')
        answer = _response(HTTPStatus.OK, 'text/html; charset=utf-8', self._page)
        if token and in_address:
            answer.headers['Set-Cookie'] = token.cookie
        return answer

    async def _talk(self, connection: ServerConnection) -> None:
        assert self._feed
        waiting: asyncio.Queue[bytes] = asyncio.Queue(_MOST_WAITING)
        waiting.put_nowait(self._feed.snapshot())
        self._viewers[connection] = waiting
        sending = asyncio.create_task(_pass_on(connection, waiting))
        try:
            async for message in connection:
                if not self._take(message):
                    break
        finally:
            sending.cancel()
            self._viewers.pop(connection, None)

    def _take(self, message: str | bytes) -> bool:
        """Queue the action in a message; return whether it has one."""
        if not self._takes_actions or isinstance(message, bytes):
            return False
        try:
            self.actions.put_nowait(_ACTIONS.decode(message))
        except (msgspec.MsgspecError, UnicodeError, RecursionError, queue.Full):
            return False
        return True

    def _send(self, messages: Sequence[Mapping[str, Any]]) -> None:
        assert self._feed
        encoded = self._feed.take(messages)
        for connection, waiting in list(self._viewers.items()):
            if waiting.full():
                del self._viewers[connection]
                connection.transport.abort()
            else:
                waiting.put_nowait(encoded)


def announce(server: PageServer, options: BrowserOptions) -> None:
    """Print the address of the page, and who else may press its buttons."""
    taken = '' if server.port == options.port else f' (port {options.port} is taken)'
    print(f'browser view: {server.url}{taken}', flush=True)
    if options.host in EVERYWHERE:
        other = address_url(_way_out(), server.port) + server.query
        print(f'browser view for other machines: {other}', flush=True)
    if server.query:
        print(
            f'warning: with --host {options.host} whoever has this address can press the buttons '
            'that pause, stop, start and reset robots; --read-only removes them',
            file=sys.stderr,
            flush=True,
        )


async def _pass_on(connection: ServerConnection, waiting: asyncio.Queue[bytes]) -> None:
    with contextlib.suppress(ConnectionClosed):
        while True:
            await connection.send(await waiting.get(), text=True)


async def _close(server: Server) -> None:
    for connection in server.connections:
        connection.transport.abort()
    server.close()


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


class Token:
    """A secret in the address of the page, which the browser then keeps as a cookie.

    Attributes:
        query: End of the page's address.
        cookie: The header that lets a browser keep the token.
    """

    def __init__(self, port: int) -> None:
        """Make one for a page at a port: cookies are those of a host, whatever its port."""
        self._value = secrets.token_urlsafe()
        self._name = f'setcmas_{port}'
        self.query = f'/?token={self._value}'
        self.cookie = f'{self._name}={self._value}; HttpOnly; SameSite=Strict; Path=/'

    def is_in_address(self, path: str) -> bool:
        """Return whether it is in the path of a request, with its query."""
        return any(map(self._is, parse_qs(urlsplit(path).query).get('token', [])))

    def is_kept(self, cookies: str) -> bool:
        """Return whether it is in the Cookie header of a request."""
        try:
            kept = SimpleCookie(cookies).get(self._name)
        except CookieError:
            return False
        return kept is not None and self._is(kept.value)

    def _is(self, text: str) -> bool:
        return secrets.compare_digest(text.encode(), self._value.encode())


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


def _way_out() -> str:
    """Return the address from which this machine would talk to others, else its name."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(('192.0.2.1', 9))  # sends nothing; the system chooses the way
            return str(probe.getsockname()[0])
        except OSError:
            return socket.gethostname()


def address_url(host: str, port: int) -> str:
    """Return the address of a page."""
    return f'http://[{host}]:{port}' if ':' in host else f'http://{host}:{port}'
