"""Announcement of the page in the terminal."""

from __future__ import annotations

import sys

from setcmas_tools.view.page.browser_options import EVERYWHERE, BrowserOptions
from setcmas_tools.view.page.page import Page, network_urls


def announce(page: Page, options: BrowserOptions) -> None:
    """Print where the page is found, and who else may press its buttons."""
    taken = '' if page.port == options.port else f' (port {options.port} is taken)'
    print(f'browser view: {page.url}{taken}', flush=True)
    if options.host in EVERYWHERE:
        others = ', '.join(network_urls(page.port, page.query))
        print(f'browser view for other machines: {others}', flush=True)
    if page.query and not options.is_local:
        print(
            f'warning: with --host {options.host} whoever has this address can press the buttons '
            'that start, pause and reset robots; --read-only removes them',
            file=sys.stderr,
            flush=True,
        )
