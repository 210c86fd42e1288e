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

from setcmas_ctrl import drawing
from setcmas_ctrl.communication.triggering_conditions import CTC, checked_answer, takes_velocities
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.loader import load_script
from setcmas_ctrl.scripts.script_errors import ControlError, failure_of
from setcmas_ctrl.scripts.shared_state import kept_state, seed_scripts
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.child_channel import Channel

REQUEST = struct.Struct('<?xxxxxxxd')
"""Whether a new adjacency matrix follows the poses, and time in s.

The numbers of the arrays that the function takes follow.
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


class Refusal(msgspec.Struct, frozen=True):
    """An error instead of an answer: its kind, such as ValueError, and place; 0 is no line."""

    message: str
    kind: str = ''
    file: str = ''
    line: Annotated[int, msgspec.Meta(ge=0, le=10**9)] = 0


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

    @kept_state()
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
            is_new, t = REQUEST.unpack_from(request)
            numbers: Floats = np.frombuffer(request, offset=REQUEST.size)
            if is_new:
                adjacency = numbers[3 * nb_robots :].reshape(nb_robots, nb_robots)
            return VELOCITY.pack(
                *law(numbers[: 3 * nb_robots].reshape(3, nb_robots), t, adjacency)
            )

        return False, answer

    def _condition(self) -> tuple[bool, Callable[[bytes], bytes]]:
        """Load the condition; return whether it takes velocities, and a function of requests."""
        path = Path(self.script).resolve()
        condition: Any = vars(load_script(path, self.robot, CTC)).get('ctc')

        def answer(request: bytes) -> bytes:
            _, t = REQUEST.unpack_from(request)
            vectors = np.frombuffer(request, offset=REQUEST.size).reshape(-1, 3).copy()
            try:
                result = condition(*vectors, t)
            except BaseException as error:
                raise failure_of(error, path) from error
            return TRIGGERED.pack(checked_answer(result, path))

        return takes_velocities(condition, path.name), answer


def import_for_scripts() -> None:
    """Import the modules of setcmas that scripts may import: confined, they cannot read them."""
    for name in _FOR_SCRIPTS:
        importlib.import_module(name)
    tools = importlib.import_module('setcmas_tools')
    for name in tools.__all__:
        with suppress(SetcmasError):  # an extra is missing
            getattr(tools, name)


def _refusal(error: ControlError) -> Refusal:
    kind, file, line = cast(tuple[Any, Any, Any], error.key)
    if kind == 'result':
        return Refusal(str(error), f'{kind} {file} {line}')
    return Refusal(str(error), kind, file.name, line or 0)


def _encoded(refusal: Refusal) -> bytes:
    short = msgspec.structs.replace(refusal, message=refusal.message[:_LONGEST_TEXT])
    return msgspec.json.encode(short)
