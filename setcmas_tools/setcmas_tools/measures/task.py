"""Task: what robots should achieve, its references, and its errors in a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.laws.references import TASKS, TaskNames, checked_references
from setcmas_ctrl.laws.script_loader import plain_values
from setcmas_ctrl.laws.script_search import find_script
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metric import Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class Errors:
    """Errors of a task by robot, at the times of `Run.counted_grid`; the label has their unit."""

    title: str
    label: str
    values: Mapping[int, Floats]

    @property
    def unit(self) -> str:
        """The unit at the end of the label, such as 'm' of 'distance (m)'; '' if it has none."""
        return self.label.rpartition('(')[2][:-1] if self.label.endswith(')') else ''


class Task(TaskNames):
    """A task; a package adds one with an object of its own subclass under the task's name.

    The references of a run are `run.references.values`, by their names in the task.
    """

    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        """Return the metrics of the task, by their names in metrics.yaml."""
        del run, references
        return {}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors | None:
        """Return the error of each robot over time; None if unknown."""
        del run, references
        return None

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        """Draw the references and return entries for the legend.

        The plot is 'trajectories' or 'film' (the plane in m), or 'distances' (of pairs, in m over
        time).
        """
        del plot, axes, run, references
        return []


DOTTED: dict[str, Any] = {'color': '0.15', 'linestyle': (0, (1, 2)), 'zorder': 2.6}
"""Line style of references."""


def line_width() -> float:
    """Return the line width of a reference in points."""
    from matplotlib import rcParams  # here: who measures does not draw

    return 0.7 * float(rcParams['lines.linewidth'])


def hollow_marker(marker: str, size: float) -> dict[str, Any]:
    """Return the style of a hollow marker, its size relative to normal markers."""
    from matplotlib import rcParams

    return {
        'marker': marker,
        'markersize': size * rcParams['lines.markersize'],
        'markerfacecolor': 'none',
        'markeredgecolor': '0.15',
        'markeredgewidth': line_width(),
        'linestyle': '',
        'zorder': 2.7,
    }


def ignore(_: str) -> None:
    """Discard a message that is shown elsewhere."""


def task_of(run: Run, warn: Callable[[str], None]) -> tuple[Task, Mapping[str, Any]] | None:
    """Return the task of a run and its references; None, with a warning, if it cannot be used."""
    if run.references is None:
        return None
    try:
        task = TASKS.get(run.references.task)
    except SetcmasError as error:
        warn(str(error))
        return None
    return (task, run.references.values) if isinstance(task, Task) else None


def errors_of(run: Run) -> Errors | None:
    """Return the errors of a run's task over time; None if it has none at t >= 0."""
    known = task_of(run, ignore)
    return known[0].errors(run, known[1]) if known and len(run.counted.t) else None


def rms_by_robot(t: Floats, errors: dict[int, Floats], share: float) -> dict[int, float]:
    """Return RMS errors by robot after a share of the run, for robots with known errors."""
    late = from_share(t, share)
    known = {robot: values[late & np.isfinite(values)] for robot, values in errors.items()}
    return {robot: rms(values) for robot, values in known.items() if len(values)}


def from_share(t: Floats, share: float) -> NDArray[np.bool_]:
    """Return a mask of the times after a share of the run."""
    if not len(t):
        return np.zeros(0, dtype=bool)
    begin = t[0] + share * (t[-1] - t[0])
    return np.asarray(t >= begin - 1e-9)


def rms(values: Floats | list[float]) -> float:
    """Return the root mean square of values."""
    return float(np.sqrt(np.mean(np.square(values))))


def with_task_of(run: Run, algo: str) -> Run:
    """Return a run with the task and the references that a control script declares.

    The script is read, not run: `WPL = [[1, 1], [2, 2]]` is a plain value, a computed value is
    not.

    Raises:
        SetcmasError: The script is unknown, declares no task, or lacks a reference of it.
    """
    script = find_script(algo)
    values = plain_values(script)
    task = values.get('task')
    if not isinstance(task, str):
        raise SetcmasError(
            f"{script.name} declares no task; add a line such as task = 'waypoints', one of "
            f'{", ".join(TASKS.plugins())}'
        )
    references = checked_references(task, values, script.name)
    return replace(run, references=references)
