"""Run of a submission: the simulation is here, the script in a confined process.

A call of the submission's law goes from `RunScript` through `ConfinedProcess` (sandbox.py) to
`ConfinedScript` (confined_program.py) in the other process, which calls a `ControlLaw`.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from typing import Any, NoReturn

import msgspec
import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.communication.message_content import decoded, encoded
from setcmas_ctrl.laws.script_errors import ControlError, StopCall, safe_text
from setcmas_simu.script_calls import Function
from setcmas_tools.grade.mark_records import Failure, ScenarioRun
from setcmas_tools.grade.rubric import MarkedScenario
from setcmas_tools.offline.offline_simulation import simulate
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.submissions.confined_program import (
    FOLDER,
    Answer,
    Request,
    RunWork,
)
from setcmas_tools.submissions.robot_functions import asking
from setcmas_tools.submissions.sandbox import ConfinedProcess, NoProcessError, ProcessEndedError
from setcmas_tools.submissions.submissions import Submission

# What a confined process writes may be anything: lines of more than nine digits are none.
_FRAME = re.compile(rf'^  File ".*?/{FOLDER}/(.*)", line (\d{{1,9}}) in ', re.MULTILINE)
_MOST_ANSWERED = 1 << 13
_INVALID = 'the submission sent an invalid reply'


class LostError(StopCall):
    """The run ends: its process has died, hung or used too much."""


@dataclass(frozen=True)
class Times:
    """How long a submission may take.

    Attributes:
        call: For a call of a function, or for loading it, in s.
        run: For all calls of a run together, in s.
    """

    call: float = 10.0
    run: float = 60.0


@dataclass(frozen=True)
class SandboxRunner:
    """Runs scenarios with a submission, each in a process of its own.

    Attributes:
        submission: A submission with a script.
        times: How long it may take.
        function: One of the `FUNCTIONS` of rubrics.
        is_confined: Whether the process is confined.
    """

    submission: Submission
    times: Times
    function: Function = Function.CONTROL
    is_confined: bool = True

    def __call__(self, scenario: MarkedScenario) -> ScenarioRun:
        """Return the run of a scenario with the submission.

        A run that the machine may have ended is repeated once.

        Raises:
            NoProcessError: The machine has ended it again.
        """
        try:
            done, was_killed = self._run(scenario)
        except NoProcessError:
            was_killed = True
        return self._run(scenario)[0] if was_killed else done

    def _run(self, scenario: MarkedScenario) -> tuple[ScenarioRun, bool]:
        """Return a run, and whether something else may have killed its process."""
        base, is_law = scenario.base, self.function is Function.CONTROL
        work = RunWork(
            self.submission.script, dict(self.submission.files), self.function, base.nb_robots,
            base.seed, dict(base.law.set) if is_law else {}, math.ceil(self.times.run),
        )  # fmt: skip
        if is_law:
            scenario = replace(scenario, base=base.replace(set={}))
        with ConfinedProcess(self.is_confined, msgspec.msgpack.encode(work)) as process:
            script = RunScript(process, work, self.times)
            try:
                # The first error is in the marks.
                run = simulate(script.scenario(scenario), warn=lambda _: None)
            except LostError:
                done = ScenarioRun(None, script.failure, is_complete=False)
                return done, script.was_killed
        return ScenarioRun(run, script.failure), False


class RunScript:
    """The functions of a fleet's robots in a confined process, as functions for the engine.

    Attributes:
        failure: The first error; None if there was none yet.
        was_killed: Whether the process was killed from outside, such as for lack of memory, or
            has killed itself.
    """

    def __init__(self, process: ConfinedProcess, work: RunWork, times: Times) -> None:
        """Use a process that has begun this work."""
        self.failure: Failure | None = None
        self.was_killed = False
        self._process = process
        self._work = work
        self._times = times
        self._left = times.run

    def scenario(self, marked: MarkedScenario) -> Scenario:
        """Return a scenario with the submission, loaded for all robots.

        Raises:
            LostError: It cannot be loaded.
        """
        function, robots = self._work.function, range(1, self._work.nb_robots + 1)
        for robot in robots:
            answer = self._asked(Request(robot), Function.LOADING, Failure(''))
            if answer.error:
                self._lose(Failure(answer.error))
        period = 1.0 / marked.base.law.rate
        functions = {
            robot: asking(function, partial(self._numbers, robot, count(0.0, period)))
            for robot in robots
        }
        return marked.with_submission(functions, function)

    def _numbers(self, robot: int, times: Iterator[float], *arguments: Any) -> tuple[float, ...]:
        """Return the numbers that a robot's function returns, and send what it sends.

        `times` are those of its calls in s, which si_to_uni does not get.

        Raises:
            ControlError: It fails.
            LostError: Its process has ended.
        """
        function, received = self._work.function, {}
        t = next(times)
        if function is Function.CONTROL:
            t = arguments[1]
            received = {sender: encoded(content) for sender, content in network.contents().items()}
        elif function is Function.CONDITION:
            t = arguments[-1]
        here = Failure('', robot=robot, t=t)
        plain = [np.asarray(one).tolist() for one in arguments]
        answer = self._asked(Request(robot, plain, received), function, here)
        try:
            if answer.sent:
                network.send(decoded(answer.sent).value)
            elif answer.uses_messages:
                network.received()
        # RuntimeError: a triggering condition must not use the network.
        except (TypeError, ValueError, OverflowError, RuntimeError):
            self._lose(replace(here, message=_INVALID))
        if answer.error:
            self.failure = self.failure or replace(here, message=answer.error)
            raise ControlError(answer.error, answer.error)
        if len(answer.numbers) != (1 if function is Function.CONDITION else 2):
            self._lose(replace(here, message=_INVALID))
        return answer.numbers

    def _asked(self, request: Request, what: Function, here: Failure) -> Answer:
        """Return what the process answers for a robot.

        Raises:
            LostError: It has ended, or its answer is none.
        """
        timeout = self._times.call
        text = what.late(self._work.script, timeout)
        if self._left < timeout:
            timeout, text = self._left, f'the run takes longer than {self._times.run:g} s'
        begin = time.monotonic()
        request = msgspec.structs.replace(request, timeout=max(timeout, 1e-6))
        content = msgspec.msgpack.encode(request)
        try:
            answer = _answer(self._process.answer(content, timeout, text, _MOST_ANSWERED))
        except ProcessEndedError as error:
            self.was_killed = error.was_killed
            own = (one for one in _FRAME.findall(error.trace) if one[0] in self._work.files)
            place = next((f' ({name}, line {line})' for name, line in own), '')
            self._lose(replace(here, message=f'{error}{place}'))
        finally:
            self._left -= time.monotonic() - begin
        if answer is None:
            self._lose(replace(here, message=_INVALID))
        return answer

    def _lose(self, failure: Failure) -> NoReturn:
        self.failure = self.failure or failure
        raise LostError(failure.message)


_decoded = msgspec.msgpack.Decoder(Answer).decode


def _answer(content: bytes) -> Answer | None:
    """Return an answer of finite numbers, or a plain error; None for what is neither."""
    try:
        sent = _decoded(content)
    except (msgspec.MsgspecError, RecursionError):
        return None
    error = safe_text(str, sent.error) if sent.error else ''
    is_finite = all(map(math.isfinite, sent.numbers))
    return msgspec.structs.replace(sent, error=error) if is_finite else None
