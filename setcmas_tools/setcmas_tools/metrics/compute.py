"""The metrics of a run: how its robots moved, and how well the task was done."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from setcmas_simu.errors import SetcmasError
from setcmas_tools.kinds.metric import METRICS, Measured
from setcmas_tools.kinds.task import task_of
from setcmas_tools.metrics.motion import largest_speed
from setcmas_tools.metrics.table import table_lines
from setcmas_tools.run.run import Run

_FIRST = ('robots', 'separation', 'consensus', 'messages')
"""What the table begins with; then comes the task, then all others."""


@dataclass(frozen=True)
class Metrics(Mapping[str, Any]):
    """The metrics of a run that apply to it, by name.

    Attributes:
        task: What the robots were to do, if that is known.
        duration_s: From the first to the last row at t >= 0.
        vnom_m_s: Largest speed that was asked of robots.
        communication: 'periodic' (each odometry is sent) or 'event-triggered'.
        parts: What was measured, by name.
    """

    task: str | None
    duration_s: float
    vnom_m_s: float
    communication: str
    parts: Mapping[str, Measured]

    def __getitem__(self, name: str) -> Any:
        """Return what was measured under a name."""
        return self.parts[name]

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter(self.parts)

    def __len__(self) -> int:
        """Return the number of metrics that apply."""
        return len(self.parts)

    def __str__(self) -> str:
        """Return the table."""
        return '\n'.join(table_lines(self.parts, self.task))


def measure(run: Run, warn: Callable[[str], None] = print) -> Metrics:
    """Return the metrics of a run.

    Args:
        run: The run; its rows at t >= 0 count.
        warn: Shows a metric that fails; the others go on.

    Raises:
        SetcmasError: There is no row at t >= 0, or vnom is no speed.
    """
    if not len(run.counted.t):
        raise SetcmasError('there is no row at t >= 0: no robot was commanded')
    triggered = bool(run.record and run.record.is_event_triggered)
    task = task_of(run, warn)
    found = _found(run, warn)
    parts = {name: found.pop(name) for name in _FIRST if name in found}
    if task:
        own, references = task
        parts |= own.metrics(run, references)
    return Metrics(
        run.references.task if task and run.references else None,
        float(run.counted.t[-1] - run.counted.t[0]),
        largest_speed(run),
        'event-triggered' if triggered else 'periodic',
        {name: part for name, part in (parts | found).items() if part is not None},
    )


def _found(run: Run, warn: Callable[[str], None]) -> dict[str, Measured | None]:
    found = {}
    for name, metric in METRICS.usable(warn).items():
        try:
            found[name] = metric(run)
        except SetcmasError:
            raise
        except Exception as error:  # a plugin may raise anything
            reason = ' '.join(f'{type(error).__name__}: {error}'.split())
            warn(f"metric '{name}' is left out: {reason}")
    return found
