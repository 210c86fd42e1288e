"""Options of the page of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import Number


@dataclass(frozen=True, kw_only=True)
class ReplayOptions(Options):
    """What of a run, or of two, the page shows at first."""

    TITLE: ClassVar[str] = 'run that is over'

    at: float | None = option(
        Number(unit='s', finite=True),
        'time of the run to open at',
        default=None,
        default_text='its begin',
    )
    beside: bool = flag('the second run beside the first one, not as ghosts over it')
