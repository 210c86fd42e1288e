"""Answers of a submission, in the process that holds it."""

from __future__ import annotations

import math
import signal
import socket
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import msgspec
import numpy as np

from setcmas_ctrl import drawing
from setcmas_ctrl.communication.triggering import CTC, checked_answer, takes_velocities
from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.scripts.loader import load_script, seed_scripts
from setcmas_ctrl.scripts.script_errors import ControlError, failure_of
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.sandbox.channel import Channel
from setcmas_tools.grade.sandbox.confinement import confine_calls
from setcmas_tools.grade.sandbox.job import (
    CALL,
    LOADED,
    MOST_ASKED,
    TRIGGERED,
    VELOCITY,
    Job,
    Refusal,
)
from setcmas_tools.offline.where import tell_where

if TYPE_CHECKING:
    from pyseccomp import SyscallFilter

_LONGEST_TEXT = 1500


class _Nowhere:
    """Shows nothing of what scripts draw; mistakes are found before it."""

    def show(self, robot: int, name: str, sphere: drawing.Sphere) -> None:
        """Show nothing."""

    def extend_trail(self, robot: int, name: str, sphere: drawing.Sphere) -> None:
        """Show nothing."""


def serve(job: Job, end: socket.socket, rules: SyscallFilter | None) -> None:
    """Load a submission for each robot, and answer for it until nobody asks any more.

    Args:
        job: What to load.
        end: Where it is asked.
        rules: The filter of system calls that is put on first; None for one that is trusted.
    """
    channel = Channel(end, MOST_ASKED)
    tell_where(Path.cwd())
    signal.signal(signal.SIGALRM, lambda *_: None)  # a script's alarm does nothing
    drawing.canvas = _Nowhere()
    if rules:
        confine_calls(rules)
    seed_scripts(job.seed)
    try:
        velocities, answer = (_conditions if job.is_condition else _laws)(job)
    except SetcmasError as error:
        _send(channel, _refused(Refusal(str(error))))
        return
    _send(channel, LOADED[velocities])
    while True:
        request = channel.receive(math.inf)
        try:
            _send(channel, answer(request))
        except ControlError as error:
            _send(channel, _refused(_described(error)))


def _send(channel: Channel, answer: bytes) -> None:
    channel.send(answer, math.inf)


def _laws(job: Job) -> tuple[bool, Callable[[bytes], bytes]]:
    """Return what answers for control laws, loaded as `simulate` does."""
    path = Path(job.script).resolve()
    robots = range(1, job.nb_robots + 1)
    laws = [ControlLaw(path, robot, job.nb_robots, job.settings) for robot in robots]
    adjacency: Floats = np.empty(0)

    def answer(request: bytes) -> bytes:
        nonlocal adjacency
        robot, is_new, t = CALL.unpack_from(request)
        numbers: Floats = np.frombuffer(request, offset=CALL.size)
        if is_new:
            adjacency = numbers[3 * job.nb_robots :].reshape(job.nb_robots, job.nb_robots)
        poses = numbers[: 3 * job.nb_robots].reshape(3, job.nb_robots)
        return VELOCITY.pack(*laws[robot - 1](poses, t, adjacency))

    return False, answer


def _conditions(job: Job) -> tuple[bool, Callable[[bytes], bytes]]:
    """Return what answers for triggering conditions, and whether they take velocities."""
    path = Path(job.script).resolve()
    scripts = [load_script(path, robot, CTC) for robot in range(1, job.nb_robots + 1)]
    conditions = [vars(script).get('ctc') for script in scripts]
    with_velocities = [takes_velocities(one, path.name) for one in conditions]

    def answer(request: bytes) -> bytes:
        robot, _, t = CALL.unpack_from(request)
        vectors = np.frombuffer(request, offset=CALL.size).reshape(-1, 3).copy()
        try:
            result = conditions[robot - 1](*vectors, t)
        except BaseException as error:
            raise failure_of(error, path) from error
        return TRIGGERED.pack(checked_answer(result, path))

    return with_velocities[0], answer


def _described(error: ControlError) -> Refusal:
    kind, file, line = cast(tuple[Any, Any, Any], error.key)
    if kind == 'result':
        return Refusal(str(error), f'{kind} {file} {line}')
    return Refusal(str(error), kind, file.name, line or 0)


def _refused(refusal: Refusal) -> bytes:
    short = msgspec.structs.replace(refusal, message=refusal.message[:_LONGEST_TEXT])
    return msgspec.json.encode(short)
