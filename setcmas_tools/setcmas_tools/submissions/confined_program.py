"""Program of a confined process: reads a submission, or runs its script for all robots of a run.

It gets its work and requests on its standard input, and answers on its standard output; each
message is a size and that many bytes. Messages are plain data.
"""

from __future__ import annotations

import faulthandler
import os
import re
import signal
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
from setcmas_ctrl.communication.triggering_conditions import (
    CTC,
    takes_velocities,
    triggering,
)
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_errors import ControlError
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
from setcmas_ctrl.si_to_uni_script import load_conversion
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function
from setcmas_tools.submissions.submissions import Packed, read_submission
from setcmas_tools.submissions.submitted_files import lay_out

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
    """A call of a robot's function; without numbers, the script is loaded for the robot.

    Attributes:
        t: Time in s.
        numbers: The arrays that the function takes, as the bytes of their float64 numbers.
        adjacency: The adjacency matrix likewise, for a law.
        received: What the robot has received, by sender, as JSON.
        timeout: How long the call may take, in s.
    """

    robot: int
    t: float = 0.0
    numbers: bytes = b''
    adjacency: bytes = b''
    received: dict[int, str] = {}
    timeout: float = 0.0


class MessageUse(msgspec.Struct, frozen=True):
    """Use of messages in a call: whether the law used any, and what it sent, as JSON or ''."""

    are_used: bool = False
    sent: str = ''


class Refusal(msgspec.Struct, frozen=True, tag=True):
    """An error instead of an answer."""

    message: str
    messages: MessageUse = MessageUse()


class Reply(msgspec.Struct, frozen=True, tag=True):
    """What a function returns: vx and vy, V and omega, or 1 or 0 for whether a condition holds.

    A script that is loaded replies no numbers.
    """

    numbers: tuple[float, ...] = ()
    messages: MessageUse = MessageUse()


Answer = Reply | Refusal
Answering = Callable[[Request], Answer]


class ConfinedScript:
    """The functions of a script, for each robot loaded anew."""

    def __init__(self, work: RunWork) -> None:
        self.work = work
        self._path = Path()
        self._functions: dict[int, Answering] = {}

    @seeded_generators()
    def serve(self, receive: Callable[[], bytes], send: Callable[[bytes], None]) -> None:
        """Answer requests until there are no more."""
        self._path = Path(self.work.script).resolve()
        seed_scripts(self.work.seed)
        decoded = msgspec.msgpack.Decoder(Request).decode
        while True:
            send(msgspec.msgpack.encode(self._answer(decoded(receive()))))

    def _answer(self, request: Request) -> Answer:
        """Answer a request; the process ends if that takes too long."""
        if _set_timer:
            _set_timer(_TIMER, request.timeout)
        try:
            if not request.numbers:
                return self._loaded(request.robot)
            return self._functions[request.robot](request)
        except (ControlError, SetcmasError) as error:
            return Refusal(_shown(error))
        finally:
            if _set_timer:
                _set_timer(_TIMER, 0)

    def _loaded(self, robot: int) -> Reply:
        """Load the script for a robot."""
        kinds = {
            Function.CONTROL: self._law,
            Function.CONDITION: self._condition,
            Function.SI_TO_UNI: self._conversion,
        }
        self._functions[robot] = kinds[self.work.function](robot)
        return Reply()

    def _law(self, robot: int) -> Answering:
        law = ControlLaw(self._path, robot, self.work.nb_robots, self.work.settings)

        def answer(request: Request) -> Answer:
            poses = np.frombuffer(request.numbers).reshape(3, -1)
            adjacency = np.frombuffer(request.adjacency).reshape(2 * poses.shape[1:])
            received = {sender: decoded(one) for sender, one in request.received.items()}
            mailbox = Mailbox(request.t, received)
            try:
                with network.exchanged_by(mailbox):
                    vx, vy = law(poses, request.t, adjacency)
            except ControlError as error:
                return Refusal(_shown(error), _messages(mailbox))
            return Reply((float(vx), float(vy)), _messages(mailbox))

        return answer

    def _condition(self, robot: int) -> Answering:
        path = self._path
        condition: Any = vars(load_script(path, robot, CTC)).get('ctc')
        triggers = triggering(condition, path)
        places = slice(None, None, 1 if takes_velocities(condition, path.name) else 2)

        def answer(request: Request) -> Reply:
            states = np.frombuffer(request.numbers).reshape(4, 3).copy()
            (answer,) = triggers(*states[places], request.t)
            return Reply((float(answer),))

        return answer

    def _conversion(self, robot: int) -> Answering:
        convert = load_conversion(self._path, robot)

        def answer(request: Request) -> Reply:
            vx, vy, *pose, komega = np.frombuffer(request.numbers).tolist()
            return Reply(tuple(map(float, convert((vx, vy), tuple(pose), komega))))

        return answer


def _messages(mailbox: Mailbox) -> MessageUse:
    sent = '' if mailbox.sent is None else encoded(Content(mailbox.t, mailbox.sent))
    return MessageUse(mailbox.are_used, sent)


def _shown(error: Exception) -> str:
    """Return a message with files relative to the folder of the submission."""
    return re.sub(rf'[^\s\'"]*/{FOLDER}/', '', str(error)[:_LONGEST_TEXT])


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
    packed = msgspec.msgpack.decode(work, type=Packed)
    limit(_READ_S)

    def read(connection: Connection) -> None:
        connection.send(msgspec.msgpack.encode(read_submission(packed)))

    return read


_READ_S = 60


def _running(work: bytes, errors: int) -> Callable[[Connection], None]:
    script = ConfinedScript(msgspec.msgpack.decode(work, type=RunWork))
    Path(FOLDER).mkdir()
    os.chdir(FOLDER)
    if hasattr(signal, 'SIGALRM'):  # a call that hangs says where, and ends the process
        faulthandler.register(signal.SIGALRM, errors, all_threads=False, chain=True)
    limit(script.work.cpu)

    def run(connection: Connection) -> None:
        lay_out(script.work.files, Path.cwd())
        script.serve(connection.receive, connection.send)

    return run
