"""Finished runs on the page, served until Ctrl-C."""

from __future__ import annotations

import os
import signal
import sys
import threading
import webbrowser

from setcmas_tools.page.browser import (
    BrowserOptions,
    FinishedRunOptions,
    may_open_windows,
)
from setcmas_tools.page.pair import Pair
from setcmas_tools.page.report import report_page
from setcmas_tools.page.server import PageServer, announce


def show_runs(pair: Pair, browser: BrowserOptions, options: FinishedRunOptions) -> None:
    """Serve the page of a run, or of two, until Ctrl-C.

    Args:
        pair: The runs.
        browser: Where the page is served.
        options: What it shows at first.

    Raises:
        SetcmasError: The page cannot be served.
    """
    stop = threading.Event()
    before = {
        number: signal.signal(number, lambda *_: stop.set())
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    server = PageServer(report_page(pair), browser.host, browser.port)
    place = '' if options.at is None else f'/#t={options.at:g}'
    try:
        announce(server, browser, place)
        if may_open_windows(os.environ, sys.platform):
            webbrowser.open(server.url + place)
        while not stop.wait(0.5):  # signals are handled between waits on Windows
            pass
    finally:
        server.stop()
        for number, handler in before.items():
            signal.signal(number, handler)
