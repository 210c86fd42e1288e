"""Functions on runs that stand in rooms above this one, imported when they are first called.

The rooms of metrics, plots and films know what a run is; a run knows their functions by name only.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from setcmas_simu.errors import SetcmasError

MEASURE = 'setcmas_tools.measures.metrics:measure'
FIGURE = 'setcmas_tools.plots.plot:figure'
FILM = 'setcmas_tools.plots.film:film'
HTML = 'setcmas_tools.summary:html'


def tool(target: str) -> Any:
    """Return a function by its module and name."""
    module, _, name = target.partition(':')
    return getattr(importlib.import_module(module), name)


def data_frame(columns: Mapping[str, Any]) -> Any:
    """Return columns as a pandas DataFrame.

    Raises:
        SetcmasError: pandas is missing.
    """
    try:
        import pandas as pd
    except ImportError as error:
        raise SetcmasError('pandas is missing; install it with pip install pandas') from error
    return pd.DataFrame(columns)
