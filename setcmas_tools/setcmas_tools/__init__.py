"""Recording, CSV files, plots, metrics, offline runs and studies of a fleet."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from setcmas_tools.grade.check import check
    from setcmas_tools.offline.offline_simulation import simulate
    from setcmas_tools.run.run import Run
    from setcmas_tools.run.scenario import Scenario
    from setcmas_tools.study.study import Study, sweep

__all__ = ['Run', 'Scenario', 'Study', 'check', 'simulate', 'sweep']

_HOMES = {
    'Run': 'setcmas_tools.run.run',
    'Scenario': 'setcmas_tools.run.scenario',
    'Study': 'setcmas_tools.study.study',
    'check': 'setcmas_tools.grade.check',
    'simulate': 'setcmas_tools.offline.offline_simulation',
    'sweep': 'setcmas_tools.study.study',
}


def __getattr__(name: str) -> Any:
    # Imported on demand: the recorder, for one, needs no control laws.
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
