"""Workers of a study: make its runs on this machine or on a cluster, in any order.

A thread has a host for scripts, which keeps its process from run to run: a run is made in a child
that has run nothing else, so rows depend neither on the order of runs nor on who makes them.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.offline.forked_child import EndedError, script_of
from setcmas_tools.offline.host import Host
from setcmas_tools.offline.script_call import Board, Kind, ScriptCall, result_of
from setcmas_tools.run.run_info import State
from setcmas_tools.study.study_row import Job, Row, one_line

_CONNECT_S = 10

_of_thread = threading.local()
_hosts: list[Host] = []


@dataclass(frozen=True)
class Workers:
    """Workers that make the runs.

    Attributes:
        jobs: Number of simultaneous runs on this machine.
        cluster: Address of a Dask scheduler whose workers make the runs; None is this machine.
    """

    jobs: int = 1
    cluster: str | None = None

    def rows(self, jobs: Iterable[Job]) -> Generator[Row, None, None]:
        """Make runs and yield their rows as they finish.

        On this machine a thread controls each process: joblib's own processes (loky) could not be
        ended individually when a script hangs.

        Raises:
            SetcmasError: The cluster does not answer, or cannot make these runs.
        """
        with needs('study'):
            import joblib

        with _dask(self.cluster) if self.cluster else _threads(self.jobs) as end:
            parallel = joblib.Parallel(return_as='generator_unordered')
            rows = parallel(joblib.delayed(make_row)(job) for job in jobs)
            try:
                yield from rows
            finally:
                end()  # otherwise joblib would wait for running runs
                rows.close()
                end()  # a thread may have begun another one meanwhile


@contextmanager
def _threads(jobs: int) -> Iterator[Callable[[], object]]:
    import joblib

    with joblib.parallel_config(backend='threading', n_jobs=jobs):
        yield close_hosts


@contextmanager
def _dask(address: str) -> Iterator[Callable[[], object]]:
    import joblib

    with _client(address) as client:
        releases = set(client.run(_release).values())
        if releases != {__version__}:
            found = ', '.join(sorted(map(str, releases))) or 'no worker'
            raise SetcmasError(
                f"cluster '{address}' has {found}; its workers must have setcmas {__version__}"
            )
        with joblib.parallel_config(backend='dask', n_jobs=-1):
            yield lambda: client.run(close_hosts)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    with needs('cluster'):
        from distributed import Client
    try:
        client = Client(address, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise SetcmasError(
            f"cluster '{address}' does not answer; must be the address of a Dask scheduler, "
            'such as tcp://10.0.0.1:8786'
        ) from error
    with client:
        yield client


def _release() -> str:
    return __version__


def make_row(job: Job) -> Row:
    """Make a run in a child of this thread's host; return its row, whatever its scripts do."""
    host: Host | None = getattr(_of_thread, 'host', None)
    if host not in _hosts:
        path = os.pathsep.join(place or str(Path.cwd()) for place in sys.path)  # of functions
        host = Host('setcmas_tools.study.study_row:warm_up', environment={'PYTHONPATH': path})
        _of_thread.host = host
        _hosts.append(host)
    assert host
    child, notes = ScriptCall(job.row).begin(host, job.files, {'AS': job.memory})
    with child:
        scripts = job.scripts(child.folder)
        try:
            late = f'ended after {job.timeout:g} s (--timeout)'
            message = child.receive(job.timeout, late, scripts)
        except EndedError as error:
            return _broken(job, notes, error, scripts)
    kind, result = result_of(message)
    if kind is Kind.RESULT and isinstance(result, Row):
        return result
    state = State.NOT_STARTED if kind is Kind.MISTAKE else State.DIED
    broken = '' if kind is Kind.MISTAKE else 'the script broke the simulation: '
    return Row(run=job.run, state=state, message=one_line(f'{broken}{result}'))


def close_hosts() -> None:
    """End the processes of all threads."""
    while _hosts:
        _hosts.pop().close()


def _broken(job: Job, notes: Board, error: EndedError, scripts: set[Path]) -> Row:
    """Return the row of a run whose process has ended."""
    robot, message = notes.robot, str(error)
    if robot:
        message = f'{robot_name(robot)}: {message}, in {notes.function.value}'
    if found := script_of(error.places, scripts):
        message += f' at {found[0].name}, line {found[1]}'
    robots = str(robot or '')
    return Row(run=job.run, state=State.DIED, robots=robots, message=one_line(message))
