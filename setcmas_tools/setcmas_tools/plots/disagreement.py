"""Plot of a fleet's disagreement over time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from setcmas_tools.kinds.plot import applies_to
from setcmas_tools.metrics.consensus import disagreement
from setcmas_tools.plots.looks.style import legend, time_axis
from setcmas_tools.run.run import Run


@applies_to(lambda run: run.record is not None and len(run.robots) > 1)
def draw_disagreement(figure: Figure, run: Run) -> None:
    """Draw V(t) = 1/2 |delta|^2 on a log scale: a straight line is exponential convergence.

    delta holds the distances to the fleet's centre; V is the Lyapunov function of Olfati-Saber
    and Murray, IEEE Transactions on Automatic Control 49(9), 2004.
    """
    figure.set_size_inches(9.0, 5.0)
    axes = figure.add_subplot(
        title='Disagreement', ylabel=r'$V = \Sigma_i\, |p_i - \bar{p}\,|^2 / 2$  (m²)'
    )
    axes.set_yscale('log')
    table, grid = run.table, run.grid()
    values = 0.5 * len(grid.robots) * disagreement(grid.x, grid.y) ** 2
    values[~(values > 0)] = np.nan  # has no logarithm
    # Matplotlib would warn of the limits that it finds for a V that stays as it is.
    axes.plot(grid.t, values, color='0.15', label='V', scaley=False)
    if np.isfinite(values).any():
        axes.set_ylim(0.7 * np.nanmin(values), 1.4 * np.nanmax(values))
    marks = time_axis([axes], table.t[0], table.t[-1])
    if marks:
        legend(axes, marks)
