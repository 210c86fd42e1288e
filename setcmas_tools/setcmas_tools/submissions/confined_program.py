"""Program of a confined process: runs the script of a submission for all robots of a run.

It gets its work and requests on its standard input, and answers on its standard output; each
message is a size and that many bytes. Messages are plain data.
"""

from __future__ import annotations

import faulthandler
import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from struct import Struct
from typing import IO, Any

import msgspec
import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.communication.message_content import (
    Content,
    Mailbox,
    decoded,
    encoded,
)
from setcmas_ctrl.laws.script_errors import ControlError
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.submissions.robot_functions import RobotFunction, robot_function
from setcmas_tools.submissions.submitted_files import lay_out

SIZE = Struct('<I')
"""Before each message: its size in bytes."""
READY = b'ready'
"""First message of the confined process, before it runs anything of a student."""
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


_LONGEST_TEXT = 1500
FOLDER = 'submission'
"""Name of the folder in which a script finds the files of its submission."""
_set_timer = getattr(signal, 'setitimer', None)
_TIMER = getattr(signal, 'ITIMER_REAL', 0)


class RunWork(msgspec.Struct, frozen=True):
    """A script to run.

    Attributes:
        script: Its name.
        files: The files of the submission, by relative path.
        function: Its function: CONTROL, CONDITION or SI_TO_UNI.
        settings: Values of the script's variables.
        cpu: Largest processor time in s.
    """

    script: str
    files: dict[str, bytes]
    function: Function
    nb_robots: int
    seed: int
    settings: dict[str, Any]
    cpu: int


class Request(msgspec.Struct, frozen=True):
    """A call of a robot's function; without arguments, the script is loaded for the robot.

    Attributes:
        arguments: Those of `robot_function`; arrays and tuples as lists.
        received: What the robot has received, by sender, as JSON.
        timeout: How long the call may take, in s.
    """

    robot: int
    arguments: list[Any] = []
    received: dict[int, str] = {}
    timeout: float = 0.0


class Answer(msgspec.Struct, frozen=True):
    """What a function returns, or its error; a script that is loaded returns no numbers.

    Attributes:
        numbers: Those of `robot_function`.
        error: The message of an error; '' without one.
        uses_messages: Whether the law has used messages.
        sent: The message that it has sent, as JSON; '' for none.
    """

    numbers: tuple[float, ...] = ()
    error: str = ''
    uses_messages: bool = False
    sent: str = ''


class ConfinedScript:
    """The functions of a script, for each robot loaded anew."""

    def __init__(self, work: RunWork) -> None:
        self.work = work
        self._path = Path()
        self._functions: dict[int, RobotFunction] = {}

    @seeded_generators()
    def serve(self, receive: Callable[[], bytes], send: Callable[[bytes], None]) -> None:
        """Answer requests until there are no more."""
        self._path = Path(self.work.script).resolve()
        seed_scripts(self.work.seed)
        decode = msgspec.msgpack.Decoder(Request).decode
        while True:
            send(msgspec.msgpack.encode(self._answer(decode(receive()))))

    def _answer(self, request: Request) -> Answer:
        """Answer a request; the process ends if that takes too long."""
        received = {sender: decoded(one) for sender, one in request.received.items()}
        mailbox = Mailbox(0.0, received)
        numbers: tuple[float, ...] = ()
        text = ''
        if _set_timer:
            _set_timer(_TIMER, request.timeout)
        try:
            numbers = self._called(request, mailbox)
        except (ControlError, SetcmasError) as error:
            text = _shown(error)
        finally:
            if _set_timer:
                _set_timer(_TIMER, 0)
        sent = '' if mailbox.sent is None else encoded(Content(mailbox.t, mailbox.sent))
        return Answer(numbers, text, mailbox.are_used, sent)

    def _called(self, request: Request, mailbox: Mailbox) -> tuple[float, ...]:
        """Call the function of a robot, or load it."""
        work, robot, function = self.work, request.robot, self.work.function
        if not request.arguments:
            self._functions[robot] = robot_function(
                function, self._path, robot, work.nb_robots, work.settings
            )
            return ()
        kind: Any = tuple if function is Function.SI_TO_UNI else np.array
        given = [kind(one) if isinstance(one, list) else one for one in request.arguments]
        if function is Function.CONTROL:
            mailbox.t = given[1]
        with network.exchanged_by(mailbox):
            return tuple(map(float, self._functions[robot](*given)))


def _shown(error: Exception) -> str:
    """Return a message with files relative to the submission, or to the folders of packages."""
    text = re.sub(rf'[^\s\'"(]*/{FOLDER}/', '', str(error)[:_LONGEST_TEXT])
    for place in sorted({*sys.path} - {''}, key=len, reverse=True):
        text = text.replace(f'{place}/', '')
    return text


def main() -> None:
    """Do the work that the grader sends."""
    connection = Connection(os.fdopen(os.dup(0), 'rb'), os.fdopen(os.dup(1), 'wb'))
    errors = os.dup(2)
    script = ConfinedScript(msgspec.msgpack.decode(connection.receive(), type=RunWork))
    Path(FOLDER).mkdir()
    os.chdir(FOLDER)
    if hasattr(signal, 'SIGALRM'):  # a call that hangs says where, and ends the process
        faulthandler.register(signal.SIGALRM, errors, all_threads=False, chain=True)
    limit(script.work.cpu)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nowhere, stream)
    os.close(nowhere)
    connection.send(READY)
    lay_out(script.work.files, Path.cwd())
    with suppress(EOFError):  # the grader has no more requests
        script.serve(connection.receive, connection.send)


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
