"""Control laws or conditions that a box holds, as functions that the engine calls."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from struct import Struct
from typing import Any, NoReturn

import msgspec
import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.scripts.script_errors import ControlError, StopCall, safe_text
from setcmas_simu.arrays import Floats
from setcmas_tools.grade.marks import Failure
from setcmas_tools.grade.rubric_scenarios import CONTROL, CTC, Scenario
from setcmas_tools.grade.sandbox.box import Box, EndedError
from setcmas_tools.grade.sandbox.job import CALL, LOADED, TRIGGERED, VELOCITY, Job, Refusal


class LostError(StopCall):
    """A run ends because its submission does not answer any more."""


@dataclass(frozen=True)
class Times:
    """How long a submission may take.

    Attributes:
        call: For a call of a function, or for loading it, in s.
        run: For all of a run, in s.
    """

    call: float = 10.0
    run: float = 60.0


class Held:
    """The laws or the conditions of a fleet, which a box holds.

    Attributes:
        trouble: The first thing that went wrong; None if nothing has yet.
    """

    def __init__(self, box: Box, files: Mapping[str, bytes], job: Job, times: Times) -> None:
        """Load them.

        Args:
            box: Holds them.
            files: The submission's files.
            job: What to load of them.
            times: How long it may take.
        """
        self.trouble: Failure | None = None
        self._box = box
        self._job = job
        self._times = times
        self._adjacency: Floats | None = None
        box.hold(files, job)
        self._deadline = time.monotonic() + times.run

    def job(self, scenario: Scenario) -> dict[str, Any]:
        """Return the arguments of `simulate` for a scenario, once everything is loaded.

        Raises:
            LostError: Something cannot be loaded.
        """
        answer = self._asked(b'', f'{self._job.script} has been loading', Failure(''))
        kinds = {told: velocities for velocities, told in LOADED.items()}
        if answer not in kinds:
            self._lose(Failure(_refusal(answer).message))
        robots = range(1, self._job.nb_robots + 1)
        if self._job.is_condition:
            conditions = {robot: self._condition(robot, kinds[answer]) for robot in robots}
            return scenario.job(conditions, CTC)
        return scenario.job({robot: self._law(robot) for robot in robots}, CONTROL)

    def _law(self, robot: int) -> Callable[[int, int, Floats, float], tuple[float, float]]:
        def control(robotNo: int, nbRobots: int, poses: Floats, t: float) -> tuple[float, float]:
            del robotNo, nbRobots
            adjacency = network.adjacency()
            is_new = adjacency is not self._adjacency
            self._adjacency = adjacency
            arrays = (poses, adjacency) if is_new else (poses,)
            vx, vy = self._answer(robot, t, arrays, VELOCITY, is_new)
            return vx, vy

        return control

    def _condition(self, robot: int, velocities: bool) -> Callable[..., bool]:
        def asked(*vectors: Floats, t: float) -> bool:
            return bool(self._answer(robot, t, vectors, TRIGGERED)[0])

        def ctc(pos: Floats, last_pos: Floats, t: float) -> bool:
            return asked(pos, last_pos, t=t)

        def long_ctc(
            pos: Floats, vit: Floats, last_pos: Floats, last_vit: Floats, t: float
        ) -> bool:
            return asked(pos, vit, last_pos, last_vit, t=t)

        return long_ctc if velocities else ctc

    def _answer(
        self, robot: int, t: float, arrays: Sequence[Floats], form: Struct, is_new: bool = False
    ) -> tuple[Any, ...]:
        """Return the numbers that the function of a robot answers.

        Raises:
            ControlError: It fails.
            LostError: It will not answer any more.
        """
        request = CALL.pack(robot, is_new, t)
        request += b''.join(np.asarray(array, dtype=float).tobytes() for array in arrays)
        here = Failure('', robot=robot, t=t)
        name = CTC if self._job.is_condition else CONTROL
        answer = self._asked(request, f'{name} has not returned', here)
        if len(answer) == form.size:
            return form.unpack(answer)
        told = _refusal(answer)
        if not self.trouble:
            self.trouble = replace(here, message=told.message, script=told.file, line=told.line)
        place = Path(told.file), told.line
        raise ControlError(told.message, (told.kind, *place), place=place)

    def _asked(self, request: bytes, late: str, here: Failure) -> bytes:
        left = self._deadline - time.monotonic()
        timeout, text = self._times.call, f'{late} for {self._times.call:g} s'
        if left < timeout:
            timeout, text = left, f'the run takes longer than {self._times.run:g} s'
        try:
            return self._box.ask(request, timeout, text)
        except EndedError as error:
            self._lose(replace(here, message=str(error), script=error.file, line=error.line))

    def _lose(self, trouble: Failure) -> NoReturn:
        self.trouble = self.trouble or trouble
        raise LostError(trouble.message)


def _refusal(answer: bytes) -> Refusal:
    """Return what a submission says instead of an answer, with nothing that a terminal obeys."""
    try:
        told = msgspec.json.decode(answer, type=Refusal)
    except msgspec.MsgspecError:
        return Refusal('the submission answers in a way that makes no sense')
    message, kind, file = (safe_text(str, one) for one in (told.message, told.kind, told.file))
    return Refusal(message, kind, file, told.line)
