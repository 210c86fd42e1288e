"""Evaluation of a run: metrics, their table and file, plots, and its summary in notebooks."""

from __future__ import annotations

import base64
import html as markup
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metrics import Metrics, measure, write_yaml
from setcmas_tools.measures.task import ignore
from setcmas_tools.plots.plot_settings import PlotSettings
from setcmas_tools.run.run import Run

_LOOK = PlotSettings()


@dataclass(frozen=True)
class Evaluation:
    """Metrics and plots of a run; as text, the table of the metrics.

    Attributes:
        metrics: None if they were not measured.
        plots: The files of the plots.
    """

    metrics: Metrics | None
    plots: list[Path]

    def __str__(self) -> str:
        return str(self.metrics) if self.metrics else ''

    __repr__ = __str__


def evaluate(
    run: Run,
    folder: Path | None = None,
    look: PlotSettings = _LOOK,
    metrics_file: Path | None = None,
    warn: Callable[[str], None] = print,
) -> Evaluation:
    """Measure and plot a run, or raise SetcmasError.

    Without a folder no plots are drawn, without a metrics file nothing is measured; `warn` shows
    what fails.
    """
    figures: list[Path] = []
    if folder:
        from setcmas_tools.plots.plot import plot  # who draws nothing does not wait for matplotlib

        figures = plot(run, folder, look, warn=warn)
    metrics = None
    if metrics_file:
        metrics = measure(run, warn)
        write_yaml(metrics, metrics_file)
    return Evaluation(metrics, figures)


_DPI = 55


def html(run: Run) -> str:
    """Return a run as HTML: its title, its trajectories, and the table of its metrics."""
    from setcmas_tools.plots.plot import figure

    content = io.BytesIO()
    figure(run, 'trajectories').savefig(content, format='png', dpi=_DPI)
    picture = base64.b64encode(content.getvalue()).decode('ascii')
    try:
        table = str(measure(run, ignore))
    except SetcmasError as error:
        table = str(error)
    return (
        f'<div><b>{markup.escape(run.title)}</b> ({markup.escape(str(run.outcome))})<br>'
        f'<img src="data:image/png;base64,{picture}" alt="trajectories">'
        f'<pre style="line-height:1.2">{markup.escape(table)}</pre></div>'
    )
