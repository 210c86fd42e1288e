"""Options of the browser view, the same for `setcmas view` and for the node's own command line."""

from __future__ import annotations

import argparse

INSTALL_VISER = "pip install 'viser>=1.1,<1.2'"
"""As pyproject.toml asks for."""
HOST = '127.0.0.1'
PORT = 8080
EVERYWHERE = {'0.0.0.0': '127.0.0.1', '::': '::1'}
"""Addresses that mean all of a machine's, and how the machine itself is reached then."""


def port(text: str) -> int:
    """Return a TCP port (type of an option)."""
    if not text.isdecimal() or not 1 <= int(text) <= 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is not a port from 1 to 65535")
    return int(text)


def add_browser_arguments(group: argparse._ArgumentGroup) -> None:
    """Add --host, --port and --read-only."""
    group.add_argument(
        '--host',
        default=HOST,
        metavar='ADDRESS',
        help='address to serve the page at; 0.0.0.0 lets others on the network see it and press '
        'its buttons (default: %(default)s, this machine only)',
    )
    group.add_argument(
        '--port',
        type=port,
        default=PORT,
        metavar='PORT',
        help='port of the page; the next free one if it is taken (default: %(default)s)',
    )
    group.add_argument(
        '--read-only', action='store_true', help='no buttons that start, pause or reset robots'
    )
