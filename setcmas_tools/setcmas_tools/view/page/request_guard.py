"""Guard of the page against other pages that a browser has open.

A browser lets every page, wherever it is from, open a websocket to every server it can reach, also
to one on 127.0.0.1; the server has to look at the Origin (RFC 6455, section 10.2). viser does not,
so that any page could press the buttons that start robots.

viser 1.1 hands nothing of its server out and takes no check of requests, so `websockets` is
patched while that server starts, and only then. A proxy in front of it would be no guard: viser's
own port would still be open to the same pages.
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
from collections.abc import Collection, Iterator
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import websockets.asyncio.server
from websockets.asyncio.server import ServerConnection
from websockets.http11 import Request, Response

from setcmas_simu.errors import SetcmasError
from setcmas_tools.view.page.browser_options import INSTALL_VISER
from setcmas_tools.view.page.index_page import dress
from setcmas_tools.view.page.token import Token

_NO_TOKEN = 'open the whole address that setcmas has printed, with its token\n'


def names_of_this_machine() -> set[str]:
    """Return the names, in lower case, under which a browser may ask for the page."""
    name = socket.gethostname().lower()
    short = name.partition('.')[0]
    return {'localhost', name, short, f'{short}.local'}


def refusal(host: str, origin: str | None, names: Collection[str]) -> str:
    """Return why a request is not answered; an empty text if it is.

    Args:
        host: Its Host header: what the browser believes to talk to.
        origin: Its Origin header: whose page it is that asks; None if it says nothing, as
            programs other than browsers do.
        names: What this machine is called. A stranger's name for its address (DNS rebinding) would
            make that stranger's page its own origin; addresses cannot be made up like that.
    """
    name = _host_name(host)
    if not name or not (name in names or _is_address(name)):
        return f"this page is not called '{host}'; open it by its address, or as localhost"
    if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
        return f"pages of '{origin}' may not use this one"
    return ''


@contextlib.contextmanager
def guarded_requests(names: Collection[str], token: Token | None = None) -> Iterator[None]:
    """Let the server that viser starts meanwhile ask `refusal` first, and for a token.

    Raises:
        SetcmasError: viser has started it in another way, so that nothing would be refused.
    """
    module = websockets.asyncio.server
    serve = module.serve
    guarded = []

    def guarded_serve(*args: Any, process_request: Any, **options: Any) -> Any:
        def process(connection: ServerConnection, request: Request) -> Response | None:
            headers = request.headers
            host, origins = ', '.join(headers.get_all('Host')), headers.get_all('Origin')
            reason = refusal(host, ', '.join(origins) if origins else None, names)
            if reason:
                return connection.respond(HTTPStatus.FORBIDDEN, f'{reason}\n')
            shown = token is not None and token.is_in_address(request.path)
            if token and not shown and not token.is_kept('; '.join(headers.get_all('Cookie'))):
                return connection.respond(HTTPStatus.FORBIDDEN, _NO_TOKEN)
            response: Response | None = process_request(connection, request)
            if response is not None:  # nor may another page show this one and catch clicks
                response.headers['X-Frame-Options'] = 'DENY'
                if token and shown:
                    response.headers['Set-Cookie'] = token.cookie
                dress(response)
            return response

        guarded.append(process)
        return serve(*args, process_request=process, **options)

    module.serve = guarded_serve  # type: ignore[assignment, misc]  # a class, called
    try:
        yield
    finally:
        module.serve = serve  # type: ignore[misc]  # a class, put back
    if not guarded:
        raise SetcmasError(f'this viser cannot be guarded; one that can: {INSTALL_VISER}')


def _host_name(host: str) -> str:
    try:
        return urlsplit(f'//{host}').hostname or ''
    except ValueError:  # brackets that do not fit
        return ''


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
