"""Runs in notebooks: a picture with a table."""

from __future__ import annotations

import base64
import html as markup
import io

from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.metrics import measure
from setcmas_tools.measures.task import ignore
from setcmas_tools.plots.plot import figure
from setcmas_tools.run.run import Run

_DPI = 55


def html(run: Run) -> str:
    """Return a run as HTML: its title, its trajectories, and the table of its metrics."""
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
