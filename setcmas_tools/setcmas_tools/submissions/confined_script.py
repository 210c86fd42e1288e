"""Script of a submission, in the confined process that runs it for all robots, and messages."""

from __future__ import annotations

import signal
from collections.abc import Callable
from pathlib import Path
from struct import Struct
from typing import Annotated, Any, cast

import msgspec
import numpy as np

from setcmas_ctrl import drawing, network
from setcmas_ctrl.communication.message_content import (
    Content,
    Dimension,
    Value,
    layout,
    read_only,
    value_of,
)
from setcmas_ctrl.communication.triggering_conditions import (
    CTC,
    keywords_taken,
    takes_velocities,
    triggering,
)
from setcmas_ctrl.laws.control_law import ControlLaw
from setcmas_ctrl.laws.conversion_script import load_conversion
from setcmas_ctrl.laws.script_errors import ControlError
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.submissions.machine_paths import without_paths

REQUEST = Struct('<?xxxIIxxxxdd')
"""Whether a new adjacency matrix follows the poses, robot, count of numbers that follow, time in
s, and how long the call may take, in s. Without numbers, the script is loaded for the robot.

The numbers of the arrays that the function takes follow, then `Contents`, if there are any.
"""
LOADED = {False: b'loaded', True: b'loaded, with velocities'}
"""Answer of a script that is loaded, by whether its condition takes velocities."""
VELOCITY = Struct('<dd')
"""Answer of a law, or V and omega; one of another size is a `Reply` or a `Refusal`."""
TRIGGERED = Struct('<?')
"""Answer of a condition."""

_LONGEST_TEXT = 1500
_set_timer = getattr(signal, 'setitimer', None)
_TIMER = getattr(signal, 'ITIMER_REAL', 0)


class RunWork(msgspec.Struct, frozen=True):
    """A script to run.

    Attributes:
        script: Its name.
        files: The files of the submission, by relative path.
        function: Its function: 'control', 'ctc' or 'si_to_uni'.
        settings: Values of the script's variables.
        cpu: Largest processor time in s.
    """

    script: str
    files: dict[str, bytes]
    function: str
    nb_robots: int
    seed: int
    settings: dict[str, Any]
    cpu: int


class Encoded(msgspec.Struct, frozen=True):
    """A value: its dimensions and numbers, see `message_content.layout`; and when it was sent."""

    dimensions: list[Dimension]
    numbers: list[float]
    t: float = 0.0

    @classmethod
    def of(cls, value: Value | None, t: float = 0.0) -> Encoded | None:
        """Return a value, encoded; None for None."""
        return None if value is None else cls(*layout(value), t)

    @property
    def value(self) -> Value:
        """The value; TypeError or ValueError is raised if it is none."""
        return value_of(self.dimensions, self.numbers)


class Contents(msgspec.Struct, frozen=True):
    """What a robot has received, by sender; or the values that a condition gets, by name."""

    received: dict[int, Encoded] = {}
    values: dict[str, Encoded | None] = {}


class Messages(msgspec.Struct, frozen=True):
    """Use of messages in a call: whether the law used any, and the value that it sent."""

    are_used: bool = False
    sent: Encoded | None = None


class Refusal(msgspec.Struct, frozen=True, tag=True):
    """An error instead of an answer: its kind, such as ValueError, and place; 0 is no line."""

    message: str
    kind: str = ''
    file: str = ''
    line: Annotated[int, msgspec.Meta(ge=0, le=10**9)] = 0
    messages: Messages = Messages()


class Reply(msgspec.Struct, frozen=True, tag=True):
    """The answer of a law that uses messages: its velocity in m/s, and their use."""

    velocity: tuple[float, float]
    messages: Messages


_contents = msgspec.msgpack.Decoder(Contents).decode


class _NoCanvas:
    """Ignores what scripts draw; mistakes are found before it."""

    def show(self, robot: int, name: str, sphere: drawing.Sphere) -> None:
        """Ignore a sphere."""

    def extend_trail(self, robot: int, name: str, sphere: drawing.Sphere) -> None:
        """Ignore a point of a trail."""


Answer = Callable[[float, Floats, Contents], bytes]
"""Answers a call: time in s, the numbers of its arrays, and messages."""


class ConfinedScript:
    """The functions of a script, for each robot loaded anew."""

    def __init__(self, work: RunWork) -> None:
        self.work = work
        self._path = Path()
        self._adjacency: dict[int, Floats] = {}
        self._answers: dict[int, Answer] = {}

    @seeded_generators()
    def serve(self, receive: Callable[[], bytes], send: Callable[[bytes], None]) -> None:
        """Answer requests until there are no more."""
        self._path = Path(self.work.script).resolve()
        drawing.canvas = _NoCanvas()
        seed_scripts(self.work.seed)
        while True:
            send(self._timed(receive()))

    def _timed(self, request: bytes) -> bytes:
        is_new, robot, count, t, seconds = REQUEST.unpack_from(request)
        numbers = np.frombuffer(request, count=count, offset=REQUEST.size)
        rest = request[REQUEST.size + numbers.nbytes :]
        if _set_timer:
            _set_timer(_TIMER, seconds)
        try:
            if not count:
                return self._loaded(robot)
            if is_new:
                n = self.work.nb_robots
                numbers, matrix = numbers[: 3 * n], numbers[-n * n :]
                self._adjacency[robot] = matrix.reshape(n, n)
            return self._answers[robot](t, numbers, _contents(rest) if rest else Contents())
        except ControlError as error:
            return _encoded(_refusal(error))
        except SetcmasError as error:
            return _encoded(Refusal(str(error)))
        finally:
            if _set_timer:
                _set_timer(_TIMER, 0)

    def _loaded(self, robot: int) -> bytes:
        """Load the script for a robot; return whether it takes velocities."""
        kinds = {'control': self._law, 'ctc': self._condition, 'si_to_uni': self._conversion}
        with_velocities, self._answers[robot] = kinds[self.work.function](robot)
        return LOADED[with_velocities]

    def _law(self, robot: int) -> tuple[bool, Answer]:
        nb_robots = self.work.nb_robots
        law = ControlLaw(self._path, robot, nb_robots, self.work.settings)

        def answer(t: float, numbers: Floats, given: Contents) -> bytes:
            mailbox = network.Mailbox(
                t, {sender: Content(one.t, one.value) for sender, one in given.received.items()}
            )
            try:
                with network.exchanged_by(mailbox):
                    poses = numbers.reshape(3, nb_robots)
                    vx, vy = network.call_law(law, poses, t, self._adjacency[robot])
            except ControlError as error:
                return _encoded(_refusal(error), _messages(mailbox))
            if mailbox.are_used:
                reply = Reply((float(vx), float(vy)), _messages(mailbox))
                return msgspec.msgpack.encode(reply)
            return VELOCITY.pack(vx, vy)

        return False, answer

    def _condition(self, robot: int) -> tuple[bool, Answer]:
        path = self._path
        condition: Any = vars(load_script(path, robot, CTC)).get('ctc')
        with_velocities, names = takes_velocities(condition, path.name), keywords_taken(condition)
        triggers = triggering(condition, path)

        def answer(t: float, numbers: Floats, given: Contents) -> bytes:
            encoded = {name: given.values.get(name) for name in names}
            values = {name: one and read_only(one.value) for name, one in encoded.items()}
            (answer,) = triggers(*numbers.reshape(-1, 3).copy(), t, **values)
            return TRIGGERED.pack(bool(answer))

        return with_velocities, answer

    def _conversion(self, robot: int) -> tuple[bool, Answer]:
        convert = load_conversion(self._path, robot)

        def answer(t: float, numbers: Floats, given: Contents) -> bytes:
            del t, given
            vx, vy, *pose, komega = numbers.tolist()
            return VELOCITY.pack(*convert((vx, vy), tuple(pose), komega))

        return False, answer


def _messages(mailbox: network.Mailbox) -> Messages:
    return Messages(mailbox.are_used, Encoded.of(mailbox.sent))


def _refusal(error: ControlError) -> Refusal:
    kind, file, line = cast(tuple[Any, Any, Any], error.key)
    return Refusal(str(error), kind, file.name, line or 0)


def _encoded(refusal: Refusal, used: Messages | None = None) -> bytes:
    text = without_paths(refusal.message[:_LONGEST_TEXT])
    messages = used or refusal.messages
    return msgspec.msgpack.encode(
        msgspec.structs.replace(refusal, message=text, messages=messages)
    )
