"""A folder served over HTTP, as `python -m http.server` does."""

import contextlib
import functools
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path


class _Quiet(SimpleHTTPRequestHandler):
    def __init__(self, *given, asked: list[str], **named):
        self._asked = asked
        super().__init__(*given, **named)

    def log_message(self, *_):
        self._asked.append(self.path)


@contextlib.contextmanager
def served(folder: Path, asked: list[str] | None = None) -> Iterator[str]:
    """Serve a folder on this machine; give its address, and append each path that is asked for."""
    asked = [] if asked is None else asked
    handler = functools.partial(_Quiet, directory=str(folder), asked=asked)
    with ThreadingHTTPServer(('127.0.0.1', 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f'http://127.0.0.1:{server.server_port}'
        finally:
            server.shutdown()
            thread.join()
