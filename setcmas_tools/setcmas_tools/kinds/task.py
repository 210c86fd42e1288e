"""Tasks: what a law may say that its robots are to do, how that is measured and drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from setcmas_ctrl.task.names import TASKS, TaskNames
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_tools.kinds.metric import Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class Errors:
    """Errors of a task over time.

    Attributes:
        title: Such as 'Tracking error'.
        label: What is measured, with its unit.
        values: By robot, at the times of `Run.counted_grid`.
    """

    title: str
    label: str
    values: Mapping[int, Floats]


class Task(TaskNames):
    """A task; a package that adds one has an object of its own subclass at the task's name.

    The references of a run are `run.references.values`, by the names of the task.
    """

    def metrics(self, run: Run, references: Mapping[str, Any]) -> Mapping[str, Measured | None]:
        """Return how well the task was done, in parts of metrics.yaml by name."""
        del run, references
        return {}

    def errors(self, run: Run, references: Mapping[str, Any]) -> Errors | None:
        """Return how far robots were from what they were to do; None if nothing tells."""
        del run, references
        return None

    def draw(self, plot: str, axes: Axes, run: Run, references: Mapping[str, Any]) -> list[Line2D]:
        """Draw what the robots were to reach.

        Args:
            plot: What is drawn: 'trajectories' or 'film' (the plane in m), or 'distances' (of
                pairs in m over time).
            axes: Where it is drawn.
            run: The run.
            references: Those of the run.

        Returns:
            What to put in the legend.
        """
        del plot, axes, run, references
        return []


def task_of(run: Run, warn: Callable[[str], None]) -> tuple[Task, Mapping[str, Any]] | None:
    """Return the task of a run and its references; None if it is not known.

    Args:
        run: The run.
        warn: Shows why a task cannot be used, such as one whose package is not installed.
    """
    if run.references is None:
        return None
    try:
        task = TASKS.get(run.references.task)
    except SetcmasError as error:
        warn(str(error))
        return None
    return (task, run.references.values) if isinstance(task, Task) else None
