"""Options of an offline run by a command."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_simu.options.group import Options, option
from setcmas_simu.options.kinds import Number


@dataclass(frozen=True, kw_only=True)
class OfflineOptions(Options):
    """How long a call of a script may take."""

    call_timeout: float = option(
        Number(above=0, unit='s'),
        'end the run if a call of a script takes longer',
        default=10.0,
    )
