"""Functions on runs that stand in rooms above this one, imported when they are first called.

The rooms of metrics, plots and films know what a run is; a run knows their functions by name only.
"""

from __future__ import annotations

import importlib
from typing import Any

MEASURE = 'setcmas_tools.metrics.compute:measure'
FIGURE = 'setcmas_tools.plots.plot:figure'
FILM = 'setcmas_tools.films.film:film'
HTML = 'setcmas_tools.summary:html'
DATA_FRAME = 'setcmas_tools.summary:data_frame'


def tool(target: str) -> Any:
    """Return a function by its module and name."""
    module, _, name = target.partition(':')
    return getattr(importlib.import_module(module), name)
