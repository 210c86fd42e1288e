"""Plot of the errors of a task over time."""

from __future__ import annotations

from matplotlib.figure import Figure

from setcmas_tools.kinds.plot import applies_to
from setcmas_tools.kinds.task import Errors, task_of
from setcmas_tools.plots.lines import shared_dashes
from setcmas_tools.plots.looks.style import legend, line_look, robot_handles, time_axis
from setcmas_tools.plots.references import ignore
from setcmas_tools.run.run import Run


def _errors(run: Run) -> Errors | None:
    known = task_of(run, ignore)
    return known[0].errors(run, known[1]) if known and len(run.counted.t) else None


@applies_to(lambda run: _errors(run) is not None)
def draw_errors(figure: Figure, run: Run) -> None:
    """Draw how far each robot is from what its task asks for: the reference, its place."""
    errors = _errors(run)
    assert errors
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title=errors.title, ylabel=errors.label)
    t = run.counted_grid.t
    dashes = shared_dashes([(t, values) for values in errors.values.values()])
    for (robot, values), look in zip(errors.values.items(), dashes, strict=True):
        axes.plot(t, values, **line_look(robot, len(run.robots)) | look)
    axes.set_ylim(bottom=0.0)
    time_axis([axes], t[0], t[-1])
    legend(axes, robot_handles(sorted(errors.values)))
