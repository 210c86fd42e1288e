"""Recording, CSV files, plots, metrics and offline runs of a fleet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from setcmas_tools.offline.engine import OfflineRun, simulate

__all__ = ['OfflineRun', 'simulate']


def __getattr__(name: str) -> Any:
    # Imported on demand: the recorder, for one, needs no control laws.
    if name in __all__:
        from setcmas_tools.offline import engine as offline_engine

        return getattr(offline_engine, name)
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
