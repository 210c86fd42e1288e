"""Plot of a fleet's disagreement over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from setcmas_tools.kinds.plot import applies_to
from setcmas_tools.metrics.consensus import disagreement, is_agreement
from setcmas_tools.plots.looks.style import legend, time_axis
from setcmas_tools.run.run import Run


@applies_to(lambda run: len(run.robots) > 1 and is_agreement(run))
def draw_disagreement(figure: Figure, run: Run) -> None:
    """Draw the disagreement on a log scale: a straight line is exponential convergence.

    It is that of the metrics, so that the line falls with their rate.
    """
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(title='Disagreement', ylabel=r'$|\delta|\, /\sqrt{N}$  (m)')
    axes.set_yscale('log')
    table, grid = run.table, run.grid()
    values = disagreement(grid.x, grid.y)
    values[~(values > 0)] = np.nan  # has no logarithm
    # Matplotlib would warn of the limits that it finds for what stays as it is.
    axes.plot(grid.t, values, color='0.15', scaley=False)
    if np.isfinite(values).any():
        axes.set_ylim(0.7 * np.nanmin(values), 1.4 * np.nanmax(values))
    marks = time_axis([axes], table.t[0], table.t[-1])
    if marks:
        legend(axes, marks)
