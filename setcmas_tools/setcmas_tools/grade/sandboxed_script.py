"""Script of a submission, in the process that runs it for one robot."""

from __future__ import annotations

import importlib
import math
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
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
    checked_answer,
    takes_velocities,
    values_taken,
)
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.loader import load_script
from setcmas_ctrl.scripts.script_errors import ControlError, failure_of
from setcmas_ctrl.scripts.script_seeds import seed_scripts, seeded_generators
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.child_channel import Channel

REQUEST = struct.Struct('<?xxxId')
"""Whether a new adjacency matrix follows the poses, count of numbers that follow, and time in s.

The numbers of the arrays that the function takes follow, then `Contents`, if there are any.
"""
LOADED = {False: b'loaded', True: b'loaded, with velocities'}
"""Answer of a script that is loaded, by whether its condition takes velocities."""
VELOCITY = struct.Struct('<dd')
"""Answer of a law; an answer of another size is a `Refusal`."""
TRIGGERED = struct.Struct('<?')
"""Answer of a condition."""

_LONGEST_TEXT = 1500
_FOR_SCRIPTS = (
    'setcmas_ctrl.control.references',
    'setcmas_ctrl.control.saturation',
    'setcmas_ctrl.network',
    'setcmas_ctrl.rviz_marker',
    'setcmas_ctrl.rviz_marker_array',
    'setcmas_simu.robots.model',
)


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


_contents = msgspec.json.Decoder(Contents).decode  # made here: confined, it finds no module


class Messages(msgspec.Struct, frozen=True):
    """Use of messages in a call: whether the law used any, and the value that it sent."""

    are_used: bool = False
    sent: Encoded | None = None

    @classmethod
    def of(cls, mailbox: network.Mailbox) -> Messages:
        """Return the use of a mailbox."""
        return cls(mailbox.are_used, Encoded.of(mailbox.sent))


class Refusal(msgspec.Struct, frozen=True):
    """An error instead of an answer: its kind, such as ValueError, and place; 0 is no line."""

    message: str
    kind: str = ''
    file: str = ''
    line: Annotated[int, msgspec.Meta(ge=0, le=10**9)] = 0
    messages: Messages = Messages()


class Reply(msgspec.Struct, frozen=True):
    """The answer of a law that uses messages: its velocity in m/s, and their use."""

    velocity: tuple[float, float]
    messages: Messages


class _NoCanvas:
    """Ignores what scripts draw; mistakes are found before it."""

    def show(self, robot: int, name: str, sphere: drawing.Sphere) -> None:
        """Ignore a sphere."""

    def extend_trail(self, robot: int, name: str, sphere: drawing.Sphere) -> None:
        """Ignore a point of a trail."""


@dataclass(frozen=True)
class SandboxedScript:
    """Work of a host's child: loads the script of a robot, and answers requests until it ends.

    Attributes:
        script: Name of the script, in the folder of the child.
        is_condition: Whether it is a triggering condition; else it is a control law.
        settings: Values of the script's variables.
    """

    script: str
    is_condition: bool
    robot: int
    nb_robots: int
    seed: int
    settings: dict[str, Any]

    @seeded_generators()
    def __call__(self, channel: Channel, _: Path) -> None:
        """Answer in this process."""
        drawing.canvas = _NoCanvas()
        seed_scripts(self.seed, self.robot)
        try:
            velocities, answer = self._condition() if self.is_condition else self._law()
        except SetcmasError as error:
            channel.send(_encoded(Refusal(str(error))), math.inf)
            return
        channel.send(LOADED[velocities], math.inf)
        while True:
            request = channel.receive(math.inf)
            try:
                reply = answer(request)
            except ControlError as error:
                reply = _encoded(_refusal(error))
            channel.send(reply, math.inf)

    def _law(self) -> tuple[bool, Callable[[bytes], bytes]]:
        """Load the control law as `simulate` does; return False, and a function of requests."""
        path, nb_robots = Path(self.script).resolve(), self.nb_robots
        law = ControlLaw(path, self.robot, nb_robots, self.settings)
        adjacency: Floats = np.empty(0)

        def answer(request: bytes) -> bytes:
            nonlocal adjacency
            is_new, t, numbers, rest = _parts(request)
            if is_new:
                adjacency = numbers[3 * nb_robots :].reshape(nb_robots, nb_robots)
            poses = numbers[: 3 * nb_robots].reshape(3, nb_robots)
            given = _contents(rest) if rest else Contents()
            received = {
                sender: Content(one.t, one.value) for sender, one in given.received.items()
            }
            mailbox = network.Mailbox(t, received)
            try:
                with network.exchanged_by(mailbox):
                    vx, vy = law(poses, t, adjacency)
            except ControlError as error:
                return _encoded(_refusal(error), Messages.of(mailbox))
            if mailbox.are_used:
                reply = Reply((float(vx), float(vy)), Messages.of(mailbox))
                return msgspec.json.encode(reply)
            return VELOCITY.pack(vx, vy)

        return False, answer

    def _condition(self) -> tuple[bool, Callable[[bytes], bytes]]:
        """Load the condition; return whether it takes velocities, and a function of requests."""
        path = Path(self.script).resolve()
        condition: Any = vars(load_script(path, self.robot, CTC)).get('ctc')
        with_velocities, names = takes_velocities(condition, path.name), values_taken(condition)

        def answer(request: bytes) -> bytes:
            _, t, numbers, rest = _parts(request)
            given = _contents(rest) if rest else Contents()
            encoded = {name: given.values.get(name) for name in names}
            values = {name: one and read_only(one.value) for name, one in encoded.items()}
            try:
                result = condition(*numbers.reshape(-1, 3).copy(), t, **values)
            except BaseException as error:
                raise failure_of(error, path) from error
            return TRIGGERED.pack(checked_answer(result, path))

        return with_velocities, answer


def import_for_scripts() -> None:
    """Import the modules of setcmas that scripts may import: confined, they cannot read them."""
    for name in _FOR_SCRIPTS:
        importlib.import_module(name)
    tools = importlib.import_module('setcmas_tools')
    for name in tools.__all__:
        with suppress(SetcmasError):  # an extra is missing
            getattr(tools, name)


def _parts(request: bytes) -> tuple[bool, float, Floats, bytes]:
    """Return the parts of a request: whether the matrix is new, t, numbers, encoded contents."""
    is_new, count, t = REQUEST.unpack_from(request)
    numbers: Floats = np.frombuffer(request, count=count, offset=REQUEST.size)
    return is_new, t, numbers, request[REQUEST.size + numbers.nbytes :]


def _refusal(error: ControlError) -> Refusal:
    kind, file, line = cast(tuple[Any, Any, Any], error.key)
    if kind == 'result':
        return Refusal(str(error), f'{kind} {file} {line}')
    return Refusal(str(error), kind, file.name, line or 0)


def _encoded(refusal: Refusal, used: Messages | None = None) -> bytes:
    text, messages = refusal.message[:_LONGEST_TEXT], used or refusal.messages
    return msgspec.json.encode(msgspec.structs.replace(refusal, message=text, messages=messages))
