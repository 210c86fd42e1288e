"""Web server of the browser view: its address, its look, and its viewers."""

from __future__ import annotations

import contextlib
import errno
import io
import socket
from collections.abc import Iterator
from typing import NoReturn

import viser

from setcmas_expe.doctor.machine_checks import network_addresses
from setcmas_simu.errors import SetcmasError
from setcmas_tools.view.page.browser_options import EVERYWHERE
from setcmas_tools.view.page.request_guard import guarded_requests, names_of_this_machine
from setcmas_tools.view.page.token import Token

_PORTS_TRIED = 50


class _Server(viser.ViserServer):
    """A server that no browser can ask to publish the page on the internet."""

    def request_share_url(self, verbose: bool = True) -> str | None:  # noqa: ARG002
        """Refuse."""
        return None


class Page:
    """The page, served from a thread.

    Attributes:
        server: viser's.
        url: Where this machine finds it.
        query: What its address ends in: its token, if it needs one.
    """

    def __init__(self, host: str, port: int, needs_token: bool = False) -> None:
        """Serve the page at a host's address, at a port or the next free one.

        Args:
            host: The address.
            port: The port.
            needs_token: Whether only those may see it who know the token in its address.

        Raises:
            SetcmasError: No port is free, the address is not one of this machine, or viser
                cannot be guarded.
        """
        port = free_port(host, port)
        names = names_of_this_machine() | {host.lower()}
        token = Token(port) if needs_token else None
        self.query = token.query if token else ''
        with _silence(), guarded_requests(names, token):
            self.server = _Server(host=host, port=port, label='setcmas', verbose=False)
        self.host, self.port = host, self.server.get_port()
        self.url = _url(EVERYWHERE.get(host, host), self.port) + self.query
        self.server.gui.configure_theme(
            show_logo=False, show_share_button=False, brand_color=(37, 99, 235)
        )

    def has_viewers(self) -> bool:
        """Return whether some browser shows the page."""
        return bool(self.server.get_clients())

    def stop(self) -> None:
        """Stop to serve."""
        with _silence():
            self.server.stop()


def free_port(host: str, port: int) -> int:
    """Return the first free port of a host's address, from one on.

    Raises:
        SetcmasError: None is free, or the address is not one of this machine.
    """
    last = min(port + _PORTS_TRIED, 65536) - 1
    for candidate in range(port, last + 1):
        try:
            family, kind, _, _, address = socket.getaddrinfo(
                host, candidate, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
            )[0]
            with socket.socket(family, kind) as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind(address)
            return candidate
        except OSError as error:
            _check(error, host, candidate)
    raise SetcmasError(f'ports {port} to {last} are all taken; name another with --port')


def _check(error: OSError, host: str, port: int) -> None:
    """Pass over a port that is taken."""
    if error.errno == errno.EADDRINUSE:
        return
    if error.errno in (errno.EACCES, errno.EPERM):
        _refuse(f'port {port} is not allowed; ports from 1024 are (--port)')
    _refuse(
        f"host '{host}' is not an address of this machine; it must be 127.0.0.1, 0.0.0.0 "
        'or an address that `hostname -I` tells'
    )


def _refuse(message: str) -> NoReturn:
    raise SetcmasError(message) from None


def network_urls(port: int, query: str = '') -> list[str]:
    """Return where other machines find a page that is served at all addresses."""
    found = network_addresses()
    named = [f'{_url(address, port)}{query} ({name})' for name, address in found.items()]
    return named or [_url(_way_out(), port) + query]


def _way_out() -> str:
    """Return the address from which this machine would talk to others, else its name."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(('192.0.2.1', 9))  # sends nothing; tells the way to other machines
            return str(probe.getsockname()[0])
        except OSError:
            return socket.gethostname()


def _url(host: str, port: int) -> str:
    return f'http://[{host}]:{port}' if ':' in host else f'http://{host}:{port}'


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep viser from printing what the user is told in our own words."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
