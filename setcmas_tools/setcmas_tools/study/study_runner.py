"""Process that makes runs of a study one after the other, in copies of itself.

Run as `python -m setcmas_tools.study.study_runner FOLDER`. Jobs come on the standard input,
pickled; for each a line of JSON, a `Row`, goes to the standard output. A copy (fork) takes a few
milliseconds, has everything imported, and takes with it whatever a script has done to the process:
nothing of a run reaches the next one, so rows depend neither on the order of runs nor on who makes
them. Without fork (Windows) the runs share the process.
"""

from __future__ import annotations

import gc
import os
import pickle
import select
import shutil
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, NoReturn

import msgspec

from setcmas_ctrl.scripts import robot_script
from setcmas_ctrl.scripts.script_errors import summarise
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.offline import board
from setcmas_tools.offline.worker import only_in
from setcmas_tools.run.run_info import State
from setcmas_tools.study.study_job import Job
from setcmas_tools.study.study_row import Row, one_line, row_of

_LOOK_S = 0.005
_exit = os._exit


def main() -> None:
    """Make runs until there are no more jobs."""
    folder = Path(sys.argv[1])
    jobs, rows = os.fdopen(os.dup(0), 'rb'), os.fdopen(os.dup(1), 'wb')
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):  # what scripts print in a thousand runs is for nobody
        os.dup2(nowhere, stream)
    _warm_up()
    for job in _received(jobs):
        job.unpack(folder)
        row = _in_copy(job, folder, jobs) if hasattr(os, 'fork') else _row(job, folder)
        rows.write(msgspec.json.encode(row) + b'\n')
        rows.flush()
    shutil.rmtree(folder, ignore_errors=True)


def _warm_up() -> None:
    """Import and look up what runs need once, not in each copy, by a short run of our own law."""
    links = {'graph': 'ring', 'loss': 0.1, 'event_triggered': True}
    row_of(
        0, {'algo': 'consensus', 'nb_robots': 3, 'duration': 1.0, 'seed': 0, 'set': {}, **links}
    )
    gc.freeze()  # a copy does not touch, and so copy, what is there for all


def _received(jobs: BinaryIO) -> Iterator[Job]:
    with suppress(EOFError):
        while True:
            yield pickle.load(jobs)


def _in_copy(job: Job, folder: Path, jobs: BinaryIO) -> Row:
    """Return the row of a job, also if its script ends or hangs the process."""
    (folder / 'board').unlink(missing_ok=True)
    notes = board.Board(folder / 'board')
    source, target = os.pipe()
    process = os.fork()
    if not process:
        _work(job, folder, notes, target)
    os.close(target)
    deadline = time.monotonic() + job.timeout
    answer = _answer(source, jobs, deadline)
    os.close(source)
    status = 0 if answer.endswith(b'\n') else _status(process, jobs, deadline)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process, signal.SIGKILL)  # with what the script has started
    with suppress(ProcessLookupError, ChildProcessError):
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
    if answer.endswith(b'\n'):
        return msgspec.json.decode(answer, type=Row)
    return _broken(job, notes, _late(notes, job.timeout) if status is None else _death(status))


def _work(job: Job, folder: Path, notes: board.Board, target: int) -> NoReturn:
    """Make a run in this process, which is a copy, and end."""
    try:
        os.setpgid(0, 0)
        _limit(job.memory)
        board.current = notes
        robot_script.on_call = notes.begin
        answer = msgspec.json.encode(_row(job, folder)) + b'\n'
        while answer:
            answer = answer[os.write(target, answer) :]
        _exit(0)
    finally:  # such as where a script has closed the pipe
        _exit(1)


def _row(job: Job, folder: Path) -> Row:
    try:
        return row_of(job.run, job.parameters(folder), only_in(os.getpid()))
    except SetcmasError as error:
        state, message = State.NOT_STARTED, str(error)
    except BaseException as error:  # a script has changed what the simulation is made of
        state, message = State.DIED, f'the script broke the simulation: {summarise(error)}'
    return Row(run=job.run, state=state, message=one_line(message))


def _limit(memory: int) -> None:
    import resource  # where there is fork

    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _answer(source: int, jobs: BinaryIO, deadline: float) -> bytes:
    """Return the line that a copy writes; what there is of it if it ends or is late."""
    answer = b''
    while not answer.endswith(b'\n'):
        left = max(0.0, deadline - time.monotonic())
        ready = select.select([source, jobs.fileno()], [], [], left)[0]
        part = os.read(source, 65536) if source in ready else b''
        if not part:
            break
        answer += part
    return answer


def _status(process: int, jobs: BinaryIO, deadline: float) -> int | None:
    """Return the exit status of a copy; None if it does not end in time."""
    while time.monotonic() < deadline:
        ended, status = os.waitpid(process, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        if select.select([jobs.fileno()], [], [], _LOOK_S)[0]:  # nobody waits for the row
            break
    return None


def _broken(job: Job, notes: board.Board, reason: str) -> Row:
    robot = notes.robot
    message = f'{robot_name(robot)}: {reason}' if robot else reason
    return Row(run=job.run, state=State.DIED, robots=str(robot or ''), message=message)


def _late(notes: board.Board, timeout: float) -> str:
    place = f', in {notes.function.value}' if notes.robot else ''
    return f'ended after {timeout:g} s (--timeout){place}'


def _death(status: int) -> str:
    if status < 0:
        return f'the process was killed by {signal.Signals(-status).name}'
    return f'the process ended with exit status {status}'


if __name__ == '__main__':
    main()
