"""Program of a confined process: reads a submission, or runs its script for all robots of a run.

It gets its work and requests on its standard input, and answers on its standard output; each
message is a size and that many bytes. Messages are plain data.
"""

from __future__ import annotations

import faulthandler
import os
import signal
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from struct import Struct
from typing import IO

import msgspec

SIZE = Struct('<I')
"""Before each message: its size in bytes."""
READY = b'ready'
"""First message of the confined process, before it unpacks or runs anything of a student."""
READ, RUN = b'u', b'r'
"""First byte of the work: unpack a submission, or run its script."""
_AMOUNTS = {
    'AS': 1 << 30, 'FSIZE': 1 << 24, 'NOFILE': 64, 'CORE': 0, 'MSGQUEUE': 0, 'MEMLOCK': 0,
    'SIGPENDING': 0, 'NPROC': 1,
}  # fmt: skip
"""Limits of a confined process: of bytes, files, and processes with threads."""


class Connection:
    """Messages between the grader and a confined process, each with its size before it."""

    def __init__(self, reader: IO[bytes], writer: IO[bytes]) -> None:
        self._reader, self._writer = reader, writer

    def send(self, message: bytes) -> None:
        """Send a message; OSError is raised if no one reads."""
        self._writer.write(SIZE.pack(len(message)) + message)
        self._writer.flush()

    def receive(self, most: int = 1 << 32) -> bytes:
        """Return the next message.

        Raises:
            EOFError: There is none.
            ValueError: It has more bytes than `most`.
        """
        (size,) = SIZE.unpack(self._read(SIZE.size))
        if size > most:
            raise ValueError(size)
        return self._read(size)

    def _read(self, size: int) -> bytes:
        content = self._reader.read(size)
        if len(content) < size:
            raise EOFError
        return content


def main() -> None:
    """Do the work that the grader sends."""
    connection = Connection(os.fdopen(os.dup(0), 'rb'), os.fdopen(os.dup(1), 'wb'))
    errors = os.dup(2)
    work = connection.receive()
    act = _running(work[1:], errors) if work[:1] == RUN else _reading(work[1:])
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nowhere, stream)
    os.close(nowhere)
    connection.send(READY)
    with suppress(EOFError):  # the grader has no more requests
        act(connection)


def limit(cpu: int) -> None:
    """Limit what this process may take: processor time in s, memory, files; it cannot fork."""
    try:
        import resource
    except ImportError:  # Windows has none
        return
    for name, most in {**_AMOUNTS, 'CPU': cpu}.items():
        with suppress(AttributeError, ValueError, OSError):  # not every system has each
            hard = most + (name == 'CPU')  # SIGXCPU, whose name the grader knows, comes first
            resource.setrlimit(getattr(resource, f'RLIMIT_{name}'), (most, hard))


def _reading(work: bytes) -> Callable[[Connection], None]:
    from setcmas_tools.submissions.submissions import Packed, read_submission

    packed = msgspec.msgpack.decode(work, type=Packed)
    limit(_READ_S)

    def read(connection: Connection) -> None:
        connection.send(msgspec.msgpack.encode(read_submission(packed)))

    return read


_READ_S = 60


def _running(work: bytes, errors: int) -> Callable[[Connection], None]:
    from setcmas_tools.submissions.confined_script import ConfinedScript, RunWork
    from setcmas_tools.submissions.submitted_files import lay_out

    script = ConfinedScript(msgspec.msgpack.decode(work, type=RunWork))
    folder = Path(tempfile.mkdtemp(prefix='setcmas_'))
    os.chdir(folder)
    if hasattr(signal, 'SIGALRM'):  # a call that hangs says where, and ends the process
        faulthandler.register(signal.SIGALRM, errors, all_threads=False, chain=True)
    limit(script.work.cpu)

    def run(connection: Connection) -> None:
        lay_out(script.work.files, folder)
        script.serve(connection.receive, connection.send)

    return run
