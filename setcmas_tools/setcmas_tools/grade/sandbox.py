"""Sandbox of submissions: the simulation runs here, each robot's script in its own process."""

from __future__ import annotations

import math
import os
import pickle
import re
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from struct import Struct
from typing import Any, NoReturn

import msgspec
import numpy as np

from setcmas_ctrl import network
from setcmas_ctrl.communication.message_content import Value, layout
from setcmas_ctrl.scripts.script_errors import ControlError, StopCall, safe_text
from setcmas_simu.arrays import Floats
from setcmas_tools.grade.marks import Failure, ScenarioRun
from setcmas_tools.grade.rubric_scenarios import CONTROL, CTC, MarkedScenario
from setcmas_tools.grade.sandboxed_script import (
    LOADED,
    REQUEST,
    TRIGGERED,
    VELOCITY,
    Contents,
    Encoded,
    Refusal,
    Reply,
    SandboxedScript,
)
from setcmas_tools.offline.child_channel import MachineError
from setcmas_tools.offline.engine import simulate
from setcmas_tools.offline.fork_server import HOME, Isolation
from setcmas_tools.offline.forked_child import EndedError, script_of, times_s
from setcmas_tools.offline.host import Host
from setcmas_tools.offline.kernel_confinement import FILE_SIZE, HOME_SIZE, MEMORY, OPEN_FILES
from setcmas_tools.scenario.scenario import Scenario

_PLACE = re.compile(r'(\S+\.py), line (\d{1,9})')


class LostError(StopCall):
    """The run ends: a script has died, hung or used too much."""


@dataclass(frozen=True)
class Times:
    """How long a submission may take.

    Attributes:
        call: For a call of a function, or for loading it, in s.
        run: For a whole run, in s.
    """

    call: float = 10.0
    run: float = 60.0


def sandbox(folder: Path, confined: bool) -> Host:
    """Return a host in `folder` for scripts, which are trusted if they are not confined."""
    isolation = Isolation.CONFINED if confined else Isolation.HOME
    prepare = 'setcmas_tools.grade.sandboxed_script:import_for_scripts'
    return Host(prepare, isolation, place=folder)


@dataclass(frozen=True)
class SandboxRunner:
    """Runs scenarios with a submission whose script is in a sandbox.

    Attributes:
        host: The sandbox.
        script: Name of its script.
        files: Its files by their names, the script among them.
        times: How long it may take.
        function: CONTROL or CTC.
    """

    host: Host
    script: str
    files: Mapping[str, bytes]
    times: Times
    function: str = CONTROL

    def __call__(self, scenario: MarkedScenario) -> ScenarioRun:
        """Return the run of a scenario with the submission.

        A run that the machine may have ended is repeated once.

        Raises:
            MachineError: The machine has ended it again.
        """
        try:
            return self._run(scenario, is_last=False)
        except MachineError:
            return self._run(scenario, is_last=True)

    def _run(self, scenario: MarkedScenario, is_last: bool) -> ScenarioRun:
        base = scenario.base
        is_condition = self.function == CTC
        settings = {} if is_condition else dict(base.law.set)
        works = [
            SandboxedScript(self.script, is_condition, robot, base.nb_robots, base.seed, settings)
            for robot in range(1, base.nb_robots + 1)
        ]
        if not is_condition:
            scenario = replace(scenario, base=base.replace(set={}))
        with SandboxedScripts(self.host, self.files, works, self.times) as scripts:
            try:
                run = simulate(scripts.scenario(scenario), warn=_ignore)
            except LostError:
                if scripts.was_killed and not is_last:
                    raise MachineError from None
                return ScenarioRun(None, self._located(scripts.failure), is_complete=False)
        return ScenarioRun(run, self._located(scripts.failure))

    def _located(self, failure: Failure | None) -> Failure | None:
        """Return a failure with the lines around it."""
        if not failure:
            return None
        file, line = failure.script, failure.line
        if not line and (found := _PLACE.search(failure.message)):
            file, line = found[1], int(found[2])
        source = self.files.get(file, b'').decode(errors='replace')
        if not source or not line:
            return replace(failure, script='', line=0)
        return failure.at(file, line, source)


class SandboxedScripts:
    """The laws or conditions of a fleet in a sandbox, as functions that the engine calls.

    Robots share no process, so that they know of each other only by their links. Use as a context
    manager, which ends the processes.

    Attributes:
        failure: The first error; None if there was none yet.
        was_killed: Whether a process was killed from outside, such as for lack of memory, or
            killed itself.
    """

    def __init__(
        self,
        host: Host,
        files: Mapping[str, bytes],
        works: Sequence[SandboxedScript],
        times: Times,
    ) -> None:
        """Begin to load the scripts of robots 1 to N, `works`, with the submission's files."""
        self.failure: Failure | None = None
        self.was_killed = False
        self._works = works
        self._name = CTC if works[0].is_condition else CONTROL
        self._times = times
        self._adjacency: list[Floats | None] = [None] * len(works)
        self._deadline = time.monotonic() + times.run
        self._waited_before = times_s(os.getpid())[1]
        limits = {
            'AS': MEMORY, 'CPU': math.ceil(times.run), 'FSIZE': FILE_SIZE, 'NOFILE': OPEN_FILES,
            'MSGQUEUE': 0, 'MEMLOCK': 0, 'SIGPENDING': 0, HOME: HOME_SIZE // len(works),
        }  # fmt: skip
        self._ended = ExitStack()
        with ExitStack() as started:
            self._children = [
                started.enter_context(host.begin(pickle.dumps(work), files, limits))
                for work in works
            ]
            self._ended = started.pop_all()
        folders = {Path(name).parent for name in files}
        self._folders = [{child.folder / name for name in folders} for child in self._children]

    def __enter__(self) -> SandboxedScripts:
        """Return the functions."""
        return self

    def __exit__(self, *exc_info: object) -> None:
        """End the processes."""
        self._ended.close()

    def scenario(self, marked: MarkedScenario) -> Scenario:
        """Return a scenario with the submission, once all scripts are loaded.

        Raises:
            LostError: One cannot be loaded.
        """
        function = self._condition if self._name == CTC else self._law
        return marked.of(
            {work.robot: function(work.robot, self._loaded(work)) for work in self._works},
            self._name,
        )

    def _loaded(self, work: SandboxedScript) -> bool:
        """Wait until a script is loaded; return whether it takes velocities."""
        answer = self._asked(work.robot, b'', f'{work.script} has been loading', Failure(''))
        kinds = {loaded: velocities for velocities, loaded in LOADED.items()}
        if answer not in kinds:
            refusal = _reply(answer)
            self._lose(Failure(refusal.message if isinstance(refusal, Refusal) else _INVALID))
        return kinds[answer]

    def _law(
        self, robot: int, _: bool
    ) -> Callable[[int, int, Floats, float], tuple[float, float]]:
        def control(robotNo: int, nbRobots: int, poses: Floats, t: float) -> tuple[float, float]:
            del robotNo, nbRobots
            adjacency = network.adjacency()
            is_new = adjacency is not self._adjacency[robot - 1]
            self._adjacency[robot - 1] = adjacency
            arrays = (poses, adjacency) if is_new else (poses,)
            received = {
                sender: Encoded(*layout(content.value), content.t)
                for sender, content in network.contents().items()
            }
            given = Contents(received) if received else None
            vx, vy = self._answer(robot, t, arrays, VELOCITY, is_new, given)
            return vx, vy

        return control

    def _condition(self, robot: int, velocities: bool) -> Callable[..., bool]:
        def asked(*vectors: Floats, t: float, **values: Value | None) -> bool:
            encoded = {name: Encoded.of(value) for name, value in values.items()}
            given = Contents(values=encoded) if any(encoded.values()) else None
            return bool(self._answer(robot, t, vectors, TRIGGERED, given=given)[0])

        def ctc(pos: Floats, last_pos: Floats, t: float, *, value: Any, last_value: Any) -> bool:
            return asked(pos, last_pos, t=t, value=value, last_value=last_value)

        def long_ctc(
            pos: Floats,
            vit: Floats,
            last_pos: Floats,
            last_vit: Floats,
            t: float,
            *,
            value: Any,
            last_value: Any,
        ) -> bool:
            vectors = pos, vit, last_pos, last_vit
            return asked(*vectors, t=t, value=value, last_value=last_value)

        return long_ctc if velocities else ctc

    def _answer(
        self,
        robot: int,
        t: float,
        arrays: Sequence[Floats],
        form: Struct,
        is_new: bool = False,
        given: Contents | None = None,
    ) -> tuple[Any, ...]:
        """Return the numbers that a robot's function returns, and send what it sends.

        Raises:
            ControlError: It fails.
            LostError: Its process has ended.
        """
        request = REQUEST.pack(is_new, sum(array.size for array in arrays), t)
        request += b''.join(np.asarray(array, dtype=float).tobytes() for array in arrays)
        request += msgspec.json.encode(given) if given else b''
        here = Failure('', robot=robot, t=t)
        answer = self._asked(robot, request, f'{self._name} has not returned', here)
        if len(answer) == form.size:
            return form.unpack(answer)
        refusal = _sent_on(_reply(answer))
        if isinstance(refusal, Reply):
            return refusal.velocity
        message, place = refusal.message, (Path(refusal.file), refusal.line)
        if not self.failure:
            self.failure = replace(here, message=message, script=refusal.file, line=refusal.line)
        raise ControlError(message, (refusal.kind, *place), place=place)

    def _asked(self, robot: int, request: bytes, late: str, here: Failure) -> bytes:
        child, folders = self._children[robot - 1], self._folders[robot - 1]
        left = self._deadline - time.monotonic()
        timeout, text = self._times.call, f'{late} for {self._times.call:g} s'
        if left < timeout and (left := left + self._waited_s()) < timeout:
            timeout, text = left, f'the run takes longer than {self._times.run:g} s'
        try:
            if request:
                child.send(request, timeout)
            return child.receive(timeout, text, folders)
        except EndedError as error:
            self.was_killed = error.status == -signal.SIGKILL and not error.was_ended
            file, line = script_of(error.places, folders) or (Path(), 0)
            self._lose(replace(here, message=str(error), script=file.name, line=line))

    def _waited_s(self) -> float:
        """Return how long this process and the children had to wait for a core, in s."""
        processes = (os.getpid(), *(child.process for child in self._children))
        return sum(times_s(process)[1] for process in processes) - self._waited_before

    def _lose(self, failure: Failure) -> NoReturn:
        self.failure = self.failure or failure
        raise LostError(failure.message)


_INVALID = 'the submission sent an invalid reply'


def _reply(answer: bytes) -> Reply | Refusal:
    """Return the answer of a law that uses messages, or the error, without control characters."""
    try:
        if answer.startswith(b'{"velocity"'):
            return msgspec.json.decode(answer, type=Reply)
        sent = msgspec.json.decode(answer, type=Refusal)
    except msgspec.MsgspecError:
        return Refusal(_INVALID)
    message, kind, file = (safe_text(str, one) for one in (sent.message, sent.kind, sent.file))
    return Refusal(message, kind, file, sent.line, sent.messages)


def _sent_on(reply: Reply | Refusal) -> Reply | Refusal:
    """Use messages as the law of a reply does; return the reply, or that it is invalid."""
    try:
        if value := reply.messages.sent:
            network.send(value.value)
        elif reply.messages.are_used:
            network.received()
    except (TypeError, ValueError, OverflowError, RuntimeError):  # RuntimeError: of a condition
        return Refusal(_INVALID)
    return reply


def _ignore(_: str) -> None:
    """Print nothing: the first error is in the marks."""
