"""Options of the browser view, for `setcmas view` and for the node's own command line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import Kind, Whole

INSTALL_VISER = "pip install 'viser>=1.1,<1.2'"
"""As pyproject.toml asks for."""
HOST = '127.0.0.1'
PORT = 8080
EVERYWHERE = {'0.0.0.0': '127.0.0.1', '::': '::1'}
"""Addresses that mean all of a machine's, and how the machine itself is reached then."""


@dataclass(frozen=True, kw_only=True)
class BrowserOptions(Options):
    """Where the page is served, and what it lets one do."""

    TITLE: ClassVar[str] = 'page'

    host: str = option(
        Kind(metavar='ADDRESS'),
        'address to serve the page at; 0.0.0.0 lets others on the network see it, and press '
        'its buttons with the token that is part of the address',
        default=HOST,
        default_text=f'{HOST}, this machine only',
    )
    port: int = option(
        Whole(1, 65535, metavar='PORT'),
        'port of the page; the next free one if it is taken',
        default=PORT,
    )
    read_only: bool = flag('no buttons that start, pause or reset robots')
    operator: bool = flag('its start button starts the experiment that has opened it')

    @property
    def is_local(self) -> bool:
        """Whether the page is for this machine only."""
        return self.host in ('127.0.0.1', 'localhost', '::1')

    @property
    def needs_token(self) -> bool:
        """Whether only those may see the page who know its whole address."""
        return self.operator or not (self.is_local or self.read_only)
