"""Engine of studies: makes runs on this machine or on a cluster, in any order."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError, needs
from setcmas_tools.study.isolation import close_runners, make_row
from setcmas_tools.study.study_job import Job
from setcmas_tools.study.study_row import Row

_CONNECT_S = 10


@dataclass(frozen=True)
class Workers:
    """Who makes the runs.

    Attributes:
        jobs: How many at a time on this machine.
        cluster: Address of a Dask scheduler, whose workers make them instead; None is here.
    """

    jobs: int = 1
    cluster: str | None = None

    def rows(self, jobs: Iterable[Job]) -> Generator[Row, None, None]:
        """Make runs and yield their rows as they come.

        On this machine a thread sees to each of so many processes: joblib's own processes (loky)
        could not be ended one by one when a script hangs.

        Args:
            jobs: The runs.

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
                end()  # joblib would wait for the runs that have begun
                rows.close()


@contextmanager
def _threads(jobs: int) -> Iterator[Callable[[], object]]:
    import joblib

    with joblib.parallel_config(backend='threading', n_jobs=jobs):
        yield close_runners


@contextmanager
def _dask(address: str) -> Iterator[Callable[[], object]]:
    import joblib

    with _client(address) as client:
        releases = set(client.run(_release).values())
        if releases != {__version__}:
            told = ', '.join(sorted(map(str, releases))) or 'no worker'
            raise SetcmasError(
                f"cluster '{address}' has {told}; its workers must have setcmas {__version__}"
            )
        with joblib.parallel_config(backend='dask', n_jobs=-1):
            yield lambda: client.run(close_runners)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    with needs('cluster'):
        from distributed import Client
    try:
        client = Client(address, timeout=_CONNECT_S)
    except (OSError, ValueError) as error:
        raise SetcmasError(
            f"cluster '{address}' does not answer; it must be the address of a Dask scheduler, "
            'such as tcp://10.0.0.1:8786'
        ) from error
    with client:
        yield client


def _release() -> str:
    return __version__
