"""Script of a submission, in the confined process that runs it for all robots, and messages."""

from __future__ import annotations

import os
import re
import signal
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, cast

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
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.script_calls import Function

_LONGEST_TEXT = 1500
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
        adjacency: The adjacency matrix likewise, if it is another one than at the last call.
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
    """An error instead of an answer: its kind, such as ValueError, and place; 0 is no line."""

    message: str
    kind: str = ''
    file: str = ''
    line: Annotated[int, msgspec.Meta(ge=0, le=10**9)] = 0
    messages: MessageUse = MessageUse()


class Reply(msgspec.Struct, frozen=True, tag=True):
    """What a function returns: vx and vy, V and omega, or 1 or 0 for whether a condition holds.

    A script that is loaded replies 1 or 0 for whether its condition takes velocities.
    """

    numbers: tuple[float, ...]
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
        except ControlError as error:
            return _refusal(error)
        except SetcmasError as error:
            return Refusal(_shown(str(error)))
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
        with_velocities, self._functions[robot] = kinds[self.work.function](robot)
        return Reply((float(with_velocities),))

    def _law(self, robot: int) -> tuple[bool, Answering]:
        law = ControlLaw(self._path, robot, self.work.nb_robots, self.work.settings)
        adjacency: Floats = np.empty(0)

        def answer(request: Request) -> Answer:
            nonlocal adjacency
            poses = np.frombuffer(request.numbers).reshape(3, -1)
            if request.adjacency:
                adjacency = np.frombuffer(request.adjacency).reshape(2 * poses.shape[1:])
            received = {sender: decoded(one) for sender, one in request.received.items()}
            mailbox = Mailbox(request.t, received)
            try:
                with network.exchanged_by(mailbox):
                    vx, vy = law(poses, request.t, adjacency)
            except ControlError as error:
                return _refusal(error, _messages(mailbox))
            return Reply((float(vx), float(vy)), _messages(mailbox))

        return False, answer

    def _condition(self, robot: int) -> tuple[bool, Answering]:
        path = self._path
        condition: Any = vars(load_script(path, robot, CTC)).get('ctc')
        triggers = triggering(condition, path)

        def answer(request: Request) -> Reply:
            states = np.frombuffer(request.numbers).reshape(-1, 3).copy()
            (answer,) = triggers(*states, request.t)
            return Reply((float(answer),))

        return takes_velocities(condition, path.name), answer

    def _conversion(self, robot: int) -> tuple[bool, Answering]:
        convert = load_conversion(self._path, robot)

        def answer(request: Request) -> Reply:
            vx, vy, *pose, komega = np.frombuffer(request.numbers).tolist()
            return Reply(tuple(map(float, convert((vx, vy), tuple(pose), komega))))

        return False, answer


_NONE = MessageUse()


def _messages(mailbox: Mailbox) -> MessageUse:
    sent = '' if mailbox.sent is None else encoded(Content(mailbox.t, mailbox.sent))
    return MessageUse(mailbox.are_used, sent)


def _refusal(error: ControlError, messages: MessageUse = _NONE) -> Refusal:
    kind, file, line = cast(tuple[Any, Any, Any], error.key)
    return Refusal(_shown(str(error)), kind, file.name, line or 0, messages)


def _shown(text: str) -> str:
    return without_paths(text[:_LONGEST_TEXT])


_TEMPORARY = r'(?:/(?:setcmas_|tmp)[a-z0-9_]{8}(?![a-z0-9_]))+/?'  # as mkdtemp names them
_CUT = re.compile(r'/[^\s\'"]*(?=\.\.\.)')


def without_paths(text: str) -> str:
    """Return a message without the folders of this machine.

    Files of a submission and of packages are relative to its folder or to that of the packages;
    the home, the environment and the current folder of the grading user become '…'.
    """
    temporary = '|'.join(map(re.escape, _places([tempfile.gettempdir()])))
    text = re.sub(f'(?:{temporary}){_TEMPORARY}', '', text)
    packages, private = _places(_roots()), _places(_private_folders())
    for place in packages:
        text = text.replace(f'{place}/', '')
    for place in private:
        text = re.sub(rf'{re.escape(place)}(?![\w.-])', '…', text)
    places = [*packages, *private]

    def shortened(cut: re.Match[str]) -> str:
        return '…' if any(place.startswith(cut[0]) for place in places) else cut[0]

    return _CUT.sub(shortened, text)


def _roots() -> Iterator[str]:
    """Yield the folders of modules; loading a law adds its folder, perhaps a package."""
    yield from (one for one in sys.path if one and not Path(one, '__init__.py').exists())


def _private_folders() -> Iterator[str]:
    yield from (sys.prefix, sys.base_prefix)
    with suppress(OSError, RuntimeError):
        yield str(Path.cwd())
        yield str(Path.home())


def _places(folders: Iterable[str]) -> list[str]:
    """Return folders as given and resolved, longest first; without the root."""
    found = {place for one in folders for place in (one, os.path.realpath(one))}
    return sorted((place.rstrip('/') for place in found if len(place) > 1), key=len, reverse=True)
